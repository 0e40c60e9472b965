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
_USED = 0.999
_CALLS = 8


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
    4. With v = 0 and all thrusts scaled by u, (4.49), if yaw alone takes more than there is.

    The answer changes continuously with what is available: 3 ends where v = 0, and 4 begins there with u = 1. Scaling
    the whole demand in 4 would take yaw away at that point and give surge and sway back. Without ``yaw_priority`` all
    thrusts of the demand are scaled at once, as (4.45)-(4.49) do.

    The least power for B T = tau is positively homogeneous of degree 3/2 and convex in tau, so that its power 2/3 is a
    norm while nothing saturates, and convex and near a straight line along v: the search is a secant in it. Nothing
    relies on that: every v is tried before it is used, and the answer is always one that was found to fit.

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
        Largest number of calls, 4 or more.
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
    if power > available:
        u = phase_back_factor(available, power)
        return PowerAnswer(PowerStage.PHASE_BACK, demanded, u**1.5 * power, commands, 0.0, u, made)
    # Regula falsi in P^(2/3), Illinois variant: an end that stays twice counts half. Halving where that is slow.
    low, high = 0.0, 1.0
    target = available ** (2.0 / 3.0)
    at_low, at_high = power ** (2.0 / 3.0) - target, above ** (2.0 / 3.0) - target
    kept = 0  # calls in a row that the low end (below 0) or the high end has stayed
    widths = [1.0, 1.0]
    while made < calls and power < _USED * available:
        share = at_low / (at_low - at_high)
        if high - low > 0.5 * widths[-2] and len(widths) > 3:
            share = 0.5
        v = low + share * (high - low)
        tried, answer = allocate(_scaled(tau, v), factor)
        made += 1
        distance = tried ** (2.0 / 3.0) - target
        if tried <= available:
            low, power, commands, at_low = v, tried, answer, distance
            kept = max(kept, 0) + 1
            at_high *= 0.5 if kept > 1 else 1.0
        else:
            high, at_high = v, distance
            kept = min(kept, 0) - 1
            at_low *= 0.5 if kept < -1 else 1.0
        widths.append(high - low)
    return PowerAnswer(PowerStage.SURGE_SWAY_SCALED, demanded, power, commands, low, 1.0, made)


def _scaled(tau: FloatArray, v: float) -> FloatArray:
    return np.array((v * tau[0], v * tau[1], tau[2]))
