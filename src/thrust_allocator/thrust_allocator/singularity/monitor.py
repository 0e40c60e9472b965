"""Singularity monitoring in every step of the allocator: [Ruth] 7.7."""

from __future__ import annotations

import math
from enum import IntFlag
from typing import NamedTuple

import numpy as np

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, finite_vector
from thrust_allocator.singularity.cone import ABSENT, window_gain
from thrust_allocator.singularity.gain import METHODS, GainMethod
from thrust_allocator.singularity.minimum_norm import LINE, RAY, SECTOR
from thrust_allocator.singularity.scaling import BoolArray, Scaling, mask


class Watch(IntFlag):
    """Which minimum gains `monitor` computes."""

    GLOBAL = 1
    LOCAL = 2
    HORIZON = 4
    ALL = 7


class MonitorReading(NamedTuple):
    """What the monitor found. NaN where it was not asked.

    Attributes
    ----------
    global_gain
        With every thruster where it points. Rotating thrusters push only, fixed ones push both ways if they can.
    local_gain
        For changes about the present thrust, [Ruth] 7.2.
    horizon_gain
        With what rotating thrusters can reach within the horizon, [Ruth] (7.120)-(7.122).
    direction
        Scaled generalized force of smallest global gain, unit, shape (3,), [Ruth] (7.124).
    projection_angle, projection_length
        Of that direction in the surge-sway plane, rad and 0 to 1.
    """

    global_gain: float
    local_gain: float
    horizon_gain: float
    direction: FloatArray
    projection_angle: float
    projection_length: float

    @classmethod
    def unknown(cls, axes: int) -> MonitorReading:
        """Return a reading of nothing, with a direction over ``axes``."""
        return cls(np.nan, np.nan, np.nan, np.full(axes, np.nan), np.nan, np.nan)


def monitor(
    scaling: Scaling,
    thrust: FloatArray,
    azimuth: FloatArray,
    enabled: BoolArray,
    thrust_min: FloatArray,
    thrust_max: FloatArray,
    may_rotate: BoolArray,
    azimuth_rate: FloatArray,
    horizon: float,
    delta_minus: FloatArray,
    delta_plus: FloatArray,
    turn_low: FloatArray | None = None,
    turn_high: FloatArray | None = None,
    watch: Watch = Watch.ALL,
    method: GainMethod = "auto",
) -> MonitorReading:
    """Return the minimum gains of the present operating point.

    Columns are scaled with the limits in force, so that a thruster limited to a fifth counts for a fifth; L_typ and
    T_max mean are those of the whole vessel.

    Parameters
    ----------
    scaling
        Of the vessel, from `scaling_of`.
    thrust, azimuth
        Commands, shape (n,), N and rad.
    enabled
        Bool mask, shape (n,); the others are left out.
    thrust_min, thrust_max
        Limits in force, shape (n,), N, thrust_min <= 0 <= thrust_max.
    may_rotate
        Bool mask, shape (n,): thrusters that are allocated as rotating. They are unidirectional along their present
        direction, whatever thrust_min. The others are bidirectional where thrust_min < 0.
    azimuth_rate
        Largest turning rates, shape (n,), rad/s, not below 0.
    horizon
        t_lim, s, not below 0. Turns are cut at 90 deg either way, as in `horizon_window`.
    delta_minus, delta_plus
        Necessary available change of thrust, shape (n,), N, not above and not below 0.
    turn_low, turn_high
        How far each may turn from here, shape (n,), rad, turn_low <= 0 <= turn_high. None: any angle.
    watch
        What to compute.
    method
        As in `minimum_gain`; 'svd' would hide what is unidirectional and is refused.

    Raises
    ------
    InputError
        If a shape or type is wrong, a number not finite, one has the wrong sign, or the method is unknown or 'svd'.
    """
    n = scaling.count
    number = METHODS.get(method, -1)
    if number < 0 or method == "svd":
        names = ", ".join(name for name in METHODS if name != "svd")
        raise InputError(f"method: expected one of {names}, found {method!r}")
    low = np.full(n, -math.pi) if turn_low is None else turn_low
    high = np.full(n, math.pi) if turn_high is None else turn_high
    vectors = (thrust, azimuth, thrust_min, thrust_max, azimuth_rate, delta_minus, delta_plus, low, high)
    # One check for all, in compiled code; which one is at fault is found out only when one is.
    for vector in vectors:
        if np.shape(vector) != (n,):
            raise _complaint(n, vectors, horizon)
    direction = np.empty(3)
    readings = _read(
        scaling.lever_x,
        scaling.lever_y,
        scaling.typical_arm,
        scaling.mean_thrust_max,
        np.array(vectors, dtype=np.float64),
        mask("enabled", enabled, n, default=True),
        mask("may_rotate", may_rotate, n, default=False),
        float(horizon),
        int(watch),
        number,
        direction,
    )
    if readings[0] < 0.0:
        raise _complaint(n, vectors, horizon)
    return MonitorReading(readings[0], readings[1], readings[2], direction, readings[3], readings[4])


_NAMES = (
    "thrust",
    "azimuth",
    "thrust_min",
    "thrust_max",
    "azimuth_rate",
    "delta_minus",
    "delta_plus",
    "turn_low",
    "turn_high",
)


def _complaint(n: int, vectors: tuple[FloatArray, ...], horizon: float) -> InputError:
    """Return the error that says which input is wrong; one of them is."""
    try:
        for name, vector in zip(_NAMES, vectors, strict=True):
            finite_vector(name, vector, n)
        finite_number("horizon", horizon)
    except InputError as error:
        return error
    return InputError(
        "thrust_min, delta_minus, turn_low: expected numbers not above 0; thrust_max, azimuth_rate, delta_plus, "
        "turn_high, horizon: expected numbers not below 0; found "
        f"{[np.asarray(vector).tolist() for vector in vectors[2:]]}, horizon {horizon}"
    )


@compiled
def _read(
    lever_x: FloatArray,
    lever_y: FloatArray,
    typical_arm: float,
    mean_thrust_max: float,
    numbers: FloatArray,
    enabled: BoolArray,
    may_rotate: BoolArray,
    horizon: float,
    watch: int,
    method: int,
    direction: FloatArray,
) -> tuple[float, float, float, float, float]:
    """Return the three gains and the projection; the first is -1 if a number is not finite or of the wrong sign.

    Rows of ``numbers``, shape (9, n): thrust, azimuth, limits, turning rate, changes, turns.
    """
    n = len(lever_x)
    if not 0.0 <= horizon < math.inf:
        return -1.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        for row in range(9):
            if not math.isfinite(numbers[row, j]):
                return -1.0, 0.0, 0.0, 0.0, 0.0
        for row in (2, 5, 7):
            if numbers[row, j] > 0.0:
                return -1.0, 0.0, 0.0, 0.0, 0.0
        for row in (3, 4, 6, 8):
            if numbers[row, j] < 0.0:
                return -1.0, 0.0, 0.0, 0.0, 0.0
    share, arm_x, arm_y = np.empty(n), np.empty(n), np.empty(n)
    low, high = np.empty(n), np.empty(n)
    role = np.empty(n, dtype=np.int64)
    for j in range(n):
        share[j] = numbers[3, j] / mean_thrust_max
        arm_x[j] = lever_x[j] / typical_arm
        arm_y[j] = lever_y[j] / typical_arm
        low[j] = numbers[1, j]
        high[j] = numbers[1, j]
        role[j] = ABSENT
        if enabled[j]:
            role[j] = LINE if numbers[2, j] < 0.0 and not may_rotate[j] else RAY
    everywhere, nearby, soon = math.nan, math.nan, math.nan
    angle, length = math.nan, math.nan
    for a in range(3):
        direction[a] = math.nan
    if watch & 1:
        everywhere = window_gain(share, arm_x, arm_y, low, high, role, method, direction)
        angle = math.atan2(direction[1], direction[0])
        length = math.hypot(direction[0], direction[1])
    unused = np.empty(3)
    if watch & 4:
        reached = role.copy()
        for j in range(n):
            if enabled[j] and may_rotate[j]:
                reach = min(numbers[4, j] * horizon, 0.5 * math.pi)
                low[j] = numbers[1, j] - min(reach, -numbers[7, j])
                high[j] = numbers[1, j] + min(reach, numbers[8, j])
                reached[j] = SECTOR
        soon = window_gain(share, arm_x, arm_y, low, high, reached, method, unused)
    if watch & 2:
        for j in range(n):
            low[j] = numbers[1, j]
            high[j] = numbers[1, j]
            if not enabled[j]:
                continue
            least = 0.0 if may_rotate[j] else numbers[2, j]
            may_sink = least - numbers[5, j] <= numbers[0, j]
            may_rise = numbers[0, j] <= numbers[3, j] - numbers[6, j]
            role[j] = LINE if may_sink and may_rise else RAY if may_sink or may_rise else ABSENT
            if may_sink and not may_rise:
                share[j] = -share[j]  # (7.12)
        nearby = window_gain(share, arm_x, arm_y, low, high, role, method, unused)
    return everywhere, nearby, soon, angle, length
