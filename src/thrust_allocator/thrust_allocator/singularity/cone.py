"""Minimum gain where each rotating thruster is confined to a window of directions: [Ruth] 7.5.2 and 7.7."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, finite_vector
from thrust_allocator.singularity.gain import GainMethod, MinimumGain, method_number
from thrust_allocator.singularity.minimum_norm import LINE, PLANE, RAY, SECTOR, IntArray
from thrust_allocator.singularity.scaling import Scaling, mask, scaling_of
from thrust_allocator.singularity.theorem import gain_of

ABSENT = -1  # role of a thruster that is left out; the others are those of minimum_norm
# A window narrower than this (rad) counts as one direction. Its two constraints would be nearly the same line; what it
# adds to a gain is of its own size.
_NARROW = 1e-6
_HALF_TURN = math.pi * (1.0 + 1e-12)  # windows of 180 deg pass whatever the rounding of their ends


@compiled
def window_gain(
    share: FloatArray,
    arm_x: FloatArray,
    arm_y: FloatArray,
    low: FloatArray,
    high: FloatArray,
    role: IntArray,
    method: int,
    direction: FloatArray,
) -> float:
    """Return the minimum gain of thrusters in their roles; write its direction, shape (3,).

    Parameters
    ----------
    share
        Largest thrust of each over T_max mean, shape (n,); negative for one that only pushes backwards, (7.12).
    arm_x, arm_y
        Lever arms over L_typ, shape (n,).
    low, high
        Ends of the windows, shape (n,), rad; equal for a fixed thruster.
    role
        ABSENT, LINE, RAY, PLANE or SECTOR, shape (n,).
    method
        A number of `theorem`.
    direction
        Receives the direction.
    """
    columns, elements = 0, 0
    for j in range(len(role)):
        if role[j] != ABSENT:
            elements += 1
            wide = role[j] == PLANE or (role[j] == SECTOR and high[j] - low[j] > _NARROW)
            columns += 2 if wide else 1
    B = np.empty((3, columns))
    kind = np.empty(elements, dtype=np.int64)
    edges = np.zeros((elements, 4))
    e, i = 0, 0
    for j in range(len(role)):
        if role[j] == ABSENT:
            continue
        kind[e] = role[j]
        if role[j] == SECTOR and high[j] - low[j] <= _NARROW:
            kind[e] = RAY
        if kind[e] <= RAY:
            middle = 0.5 * (low[j] + high[j])
            c, s = math.cos(middle), math.sin(middle)
            B[0, i] = share[j] * c
            B[1, i] = share[j] * s
            B[2, i] = share[j] * (arm_x[j] * s - arm_y[j] * c)
            i += 1
        else:
            B[0, i], B[1, i], B[2, i] = share[j], 0.0, -share[j] * arm_y[j]
            B[0, i + 1], B[1, i + 1], B[2, i + 1] = 0.0, share[j], share[j] * arm_x[j]
            edges[e, 0], edges[e, 1] = math.cos(low[j]), math.sin(low[j])
            edges[e, 2], edges[e, 3] = math.cos(high[j]), math.sin(high[j])
            i += 2
        e += 1
    return gain_of(B, kind, edges, method, direction)


def window_minimum_gain(
    vessel: Vessel | Scaling,
    azimuth_low: ArrayLike,
    azimuth_high: ArrayLike,
    enabled: ArrayLike | None = None,
    unidirectional: ArrayLike | None = None,
    method: GainMethod = "auto",
) -> MinimumGain:
    """Return the minimum gain with a window of directions per azimuth thruster, [Ruth] (7.98)-(7.103), Theorem 7.4.

    Parameters
    ----------
    vessel
        A vessel, or its scaling.
    azimuth_low, azimuth_high
        Ends of the windows, shape (n,), rad, high not below low. An azimuth thruster with low = high is fixed there;
        one whose window has up to 180 deg pushes only along directions within it; one with 360 deg or more rotates
        freely. A tunnel thruster keeps its own direction whatever stands here.
    enabled
        Bool mask, shape (n,); the others are left out. None: all.
    unidirectional
        Bool mask, shape (n,): which fixed thrusters push only one way. None: all azimuth thrusters do, tunnel
        thrusters do not.
    method
        As in `minimum_gain`, without 'svd' where anything is unidirectional. 'lemma_7_1' splits fixed bidirectional
        thrusters and freely rotating ones; the components of a window's thrust may have either sign, so that its
        proof does not cover them, while Theorem 7.2's does.

    Raises
    ------
    InputError
        If a shape is wrong, an angle not finite, or a window between 180 and 360 deg wide: that is no convex set.
    """
    scaling = vessel if isinstance(vessel, Scaling) else scaling_of(vessel)
    n = scaling.count
    low = np.where(scaling.azimuth_thruster, finite_vector("azimuth_low", azimuth_low, n), scaling.direction)
    high = np.where(scaling.azimuth_thruster, finite_vector("azimuth_high", azimuth_high, n), scaling.direction)
    width = high - low
    for j in np.flatnonzero((width < 0.0) | ((width > _HALF_TURN) & (width < 2.0 * math.pi))):
        raise InputError(
            f"azimuth_high[{j}] - azimuth_low[{j}]: expected 0 to pi, or 2 pi and more, found {width[j]:.6g} rad"
        )
    if unidirectional is None:
        one_way = scaling.azimuth_thruster
    else:
        one_way = mask("unidirectional", unidirectional, n, default=True)
    role = np.where(one_way, RAY, LINE)
    role[width > 0.0] = SECTOR
    role[width >= 2.0 * math.pi] = PLANE
    role[~mask("enabled", enabled, n, default=True)] = ABSENT
    constrained = bool(np.isin(role, (RAY, SECTOR)).any())
    direction = np.empty(3)
    gain = window_gain(
        scaling.thrust_max / scaling.mean_thrust_max,
        scaling.lever_x / scaling.typical_arm,
        scaling.lever_y / scaling.typical_arm,
        low,
        high,
        role.astype(np.int64),
        method_number(method, 3, constrained),
        direction,
    )
    return MinimumGain(gain, direction)


def horizon_window(
    azimuth: ArrayLike,
    azimuth_rate: ArrayLike,
    horizon: float,
    turn_low: ArrayLike | None = None,
    turn_high: ArrayLike | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the ends of what can be reached within ``horizon``, shapes (n,), rad: [Ruth] (7.120)-(7.121).

    Either side is cut at 90 deg: [Ruth] (7.122) asks for a horizon that keeps to this. What lies beyond is left out,
    so that the gain in the window is a lower bound of what can be reached.

    Parameters
    ----------
    azimuth, azimuth_rate
        Present directions, rad, and largest turning rates, rad/s, not below 0; shape (n,).
    horizon
        t_lim, s, not below 0.
    turn_low, turn_high
        How far each may turn either way, shape (n,), rad: turn_low <= 0 <= turn_high. None: any angle.

    Raises
    ------
    InputError
        If a shape is wrong, a number not finite, or one has the wrong sign.
    """
    angle = np.atleast_1d(np.asarray(azimuth, dtype=np.float64))
    n = len(angle)
    angle = finite_vector("azimuth", azimuth, n)
    rate = finite_vector("azimuth_rate", azimuth_rate, n)
    time = finite_number("horizon", horizon)
    if time < 0.0 or (rate < 0.0).any():
        raise InputError(f"horizon, azimuth_rate: expected numbers not below 0, found {time}, {rate.tolist()}")
    reach = np.minimum(rate * time, 0.5 * math.pi)
    below, above = -reach, reach
    if turn_low is not None:
        limit = finite_vector("turn_low", turn_low, n)
        if (limit > 0.0).any():
            raise InputError(f"turn_low: expected numbers not above 0, found {limit.tolist()}")
        below = np.maximum(below, limit)
    if turn_high is not None:
        limit = finite_vector("turn_high", turn_high, n)
        if (limit < 0.0).any():
            raise InputError(f"turn_high: expected numbers not below 0, found {limit.tolist()}")
        above = np.minimum(above, limit)
    return angle + below, angle + above
