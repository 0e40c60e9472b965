"""Which part of a demand gives way when power is short: yaw last, [Ruth] 4.4.3."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic, TypeVar

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.power.total import phase_back_factor

Commands = TypeVar("Commands")
Allocate = Callable[[FloatArray, float], tuple[float, Commands]]

# The search for the scale of surge and sway ends when this share of the available power is used, or with the calls.
_USED = 0.995
_CALLS = 8
# Where least power is looked for when yaw alone takes too much: it is near 0 if it is not there.
_FIRST = 0.25
_NEAREST = 0.05


class PowerStage(IntEnum):
    """What made the power of a step fit."""

    WITHIN = 0  # it fitted
    YAW_WEIGHT = 1  # a larger weight on yaw, as the thesis proposes first
    SURGE_SWAY_SCALED = 2  # surge and sway scaled by v
    PHASE_BACK = 3  # all thrusts scaled by u


@dataclass(frozen=True, slots=True)
class PowerAnswer(Generic[Commands]):
    """Answer to a demand under a limit of total power.

    Attributes
    ----------
    stage
        What answered.
    demanded
        P_T,k: power of the demand before any limit, W. This is what a power plant is to be told.
    power
        Power of ``commands`` times u, W; at most what is available.
    commands
        As ``allocate`` returned them. The caller scales their thrusts by ``phase_back`` within its windows.
    surge_sway_scale
        v in [0, 1].
    phase_back
        u in [0, 1].
    calls
        How often ``allocate`` was called.
    """

    stage: PowerStage
    demanded: float
    power: float
    commands: Commands
    surge_sway_scale: float
    phase_back: float
    calls: int


def limit_total_power(
    allocate: Allocate[Commands],
    tau: FloatArray,
    available: float,
    yaw_weight_factor: float = 10.0,
    yaw_priority: bool = True,
    calls: int = _CALLS,
) -> PowerAnswer[Commands]:
    """Return commands for ``tau`` that take no more power than there is.

    1. As demanded, if that fits.
    2. With the weight on yaw raised by ``yaw_weight_factor``, [Ruth] 4.4.3. It helps only in saturation: otherwise
       the slack is next to zero in all axes under either weight, the commands are the same and so is their power.
    3. With surge and sway scaled by the largest v in [0, 1] that fits, yaw kept.
    4. With the v of least power and all thrusts scaled by u, (4.49), if no v fits. v is 0, or more where yaw alone
       takes more power than with some surge or sway.

    From 3 to 4 the answer changes continuously with what is available: 3 ends at the v of least power, and 4 begins
    there with u = 1. Scaling the whole demand in 4 would take yaw away at that point and give surge and sway back.
    Without ``yaw_priority`` all thrusts of the demand are scaled at once, as (4.45)-(4.49) do.

    The least power for B T = tau is positively homogeneous of degree 3/2 and convex in tau, so that its power 2/3 is a
    norm while nothing saturates, and near a straight line along v: the search interpolates it. Nothing relies on that:
    every v is tried before it is used, and the answer is always one that was found to fit.

    Parameters
    ----------
    allocate
        From generalized force (shape (3,), N, N, N m) and factor on the yaw weight to power (W, corrected by (4.44))
        and commands; changes nothing.
    tau
        Demand, shape (3,).
    available
        P_AV, W, 0 or more; infinite for no limit.
    yaw_weight_factor
        1 for a yaw weight that is large enough already: step 2 is left out.
    yaw_priority
        Whether yaw gives way last.
    calls
        Largest number of calls, 6 or more.
    """
    demanded, commands = allocate(tau, 1.0)
    if demanded <= available:
        return PowerAnswer(PowerStage.WITHIN, demanded, demanded, commands, 1.0, 1.0, 1)
    if not yaw_priority:
        u = phase_back_factor(available, demanded)
        return PowerAnswer(PowerStage.PHASE_BACK, demanded, u**1.5 * demanded, commands, 1.0, u, 1)
    made = 1
    above = demanded  # power at v = 1
    if yaw_weight_factor > 1.0:
        above, raised = allocate(tau, yaw_weight_factor)
        made += 1
        if above <= available:
            return PowerAnswer(PowerStage.YAW_WEIGHT, demanded, above, raised, 1.0, 1.0, made)
    factor = max(yaw_weight_factor, 1.0)
    power, commands = allocate(_scaled(tau, 0.0), factor)
    made += 1
    scale = 0.0
    if power > available:
        # Yaw alone may take more than yaw with some surge or sway: P^(4/3) is near a parabola in v.
        at_zero = power
        tried, answer = allocate(_scaled(tau, _FIRST), factor)
        made += 1
        middle = tried
        if tried < power:
            scale, power, commands = _FIRST, tried, answer
        v = _lowest(at_zero ** (4.0 / 3.0), middle ** (4.0 / 3.0), above ** (4.0 / 3.0))
        if power > available and v != _FIRST:
            tried, answer = allocate(_scaled(tau, v), factor)
            made += 1
            if tried < power:
                scale, power, commands = v, tried, answer
    if power > available:
        u = phase_back_factor(available, power)
        return PowerAnswer(PowerStage.PHASE_BACK, demanded, u**1.5 * power, commands, scale, u, made)
    # Chandrupatla's root finder in P^(2/3), which takes inverse quadratic interpolation where it can be trusted and
    # halves the bracket elsewhere. It aims at the middle of what is accepted.
    aim = (0.5 * (1.0 + _USED) * available) ** (2.0 / 3.0)
    ends = [(scale, power ** (2.0 / 3.0) - aim), (1.0, above ** (2.0 / 3.0) - aim)]
    last, opposite, before = ends[1], ends[0], ends[1]
    share = ends[1][1] / (ends[1][1] - ends[0][1])
    while made < calls and power < _USED * available:
        v = last[0] + share * (opposite[0] - last[0])
        tried, answer = allocate(_scaled(tau, v), factor)
        made += 1
        point = (v, tried ** (2.0 / 3.0) - aim)
        if tried <= available and v > scale:
            scale, power, commands = v, tried, answer
        if (point[1] > 0.0) == (last[1] > 0.0):
            before = last
        else:
            before, opposite = opposite, last
        last = point
        share = _next_share(last, opposite, before)
    return PowerAnswer(PowerStage.SURGE_SWAY_SCALED, demanded, power, commands, scale, 1.0, made)


def _lowest(at_zero: float, at_first: float, at_one: float) -> float:
    """Return where the parabola through values at 0, ``_FIRST`` and 1 is lowest, kept inside of 0 and 1."""
    slope_first, slope_one = (at_first - at_zero) / _FIRST, at_one - at_zero
    curvature = (slope_one - slope_first) / (1.0 - _FIRST)
    lowest = 0.5 * (_FIRST - slope_first / curvature) if curvature > 0.0 else 0.0
    return min(max(lowest, _NEAREST), 1.0 - _NEAREST)


def _next_share(last: tuple[float, float], opposite: tuple[float, float], before: tuple[float, float]) -> float:
    """Return where to try next between ``last`` (0) and ``opposite`` (1), from three points and their values."""
    (a, f_a), (b, f_b), (c, f_c) = last, opposite, before
    if f_a == f_c or f_b == f_c:  # a power that stands still
        return 0.5
    place, value = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
    if not (value * value < place and (1.0 - value) ** 2 < 1.0 - place):
        return 0.5
    share = f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
    return min(max(share, 0.0), 1.0)


def _scaled(tau: FloatArray, v: float) -> FloatArray:
    return np.array((v * tau[0], v * tau[1], tau[2]))
