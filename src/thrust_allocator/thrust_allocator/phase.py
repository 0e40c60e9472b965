"""What each thruster is doing, and what it may do in this step: [Ruth] 4.4.2 and 6.3."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from marine_model.frames import wrap_angle
from thrust_allocator.windows import LARGEST_TURN, step_window

# Share of the zero region within which a thrust counts as having left it; see `Phase.HELD`.
_RELEASE_MARGIN = 1e-6
# Share of a thruster's span below which a thrust has no direction: above the rounding of the solvers, far below c_2.
IDLE_SHARE = 1e-7


class Phase(IntEnum):
    """How a thruster is allocated in one step."""

    LOST = 0  # not allocated; its command is ramped to zero
    FIXED = 1  # along a direction that does not change
    TURNING = 2  # as fixed, while it turns at full rate to its fixed direction
    HELD = 3  # to be rotating, but still fixed: reverse thrust has to be gone first
    ROTATING = 4


@dataclass(frozen=True, slots=True)
class ThrusterLimits:
    """Limits of one thruster under the settings in force.

    Attributes
    ----------
    enabled, may_rotate
        False for a lost thruster; false for a tunnel thruster or a lost azimuth drive.
    rotating
        The azimuth mode asks for a rotating thruster.
    thrust_min, thrust_max
        Limits in force, N.
    thrust_rate, azimuth_rate
        N/s, rad/s.
    fixed_direction
        Where the thruster points when held fixed, rad in [-pi, pi).
    zero_thrust
        c_2 (|T_max| + |T_min|), N, [Ruth] 6.3.
    span
        |T_max| + |T_min|, N: the size of this thruster, for tolerances.
    """

    enabled: bool
    may_rotate: bool
    rotating: bool
    thrust_min: float
    thrust_max: float
    thrust_rate: float
    azimuth_rate: float
    fixed_direction: float
    zero_thrust: float
    span: float


class Plan(NamedTuple):
    """What one thruster may do in one step.

    ``thrust_lower`` and ``thrust_upper`` are T_- and T_+ (N). A rotating thruster starts from ``azimuth`` and may
    turn by ``turn_low`` to ``turn_high`` (rad); any other points along ``azimuth`` in this step.
    """

    phase: Phase
    thrust_lower: float
    thrust_upper: float
    azimuth: float
    turn_low: float
    turn_high: float


def plan_thruster(limits: ThrusterLimits, thrust: float, azimuth: float, dt: float, approach: float) -> Plan:
    """Return what a thruster may do in the next step.

    A switch needs no memory: what a thruster does follows from the settings and its last command. From rotating to
    fixed it turns to its fixed direction at full rate and is allocated as fixed, reverse thrust included, on the way.
    From fixed to rotating it stays fixed where it points, with its least thrust raised to -zero_thrust, until its
    thrust is up there.

    [Ruth] 6.3 releases it when T_0 is above that limit. A thruster that is wanted the other way round sits exactly on
    the limit and would never be released; here the limit itself counts as reached.

    Parameters
    ----------
    limits
        Limits of the thruster.
    thrust, azimuth
        Command of the step before: T_0 (N), alpha_0 (rad in [-pi, pi)).
    dt
        Time step, s.
    approach
        c_1.
    """
    thrust_step = limits.thrust_rate * dt
    if not limits.enabled:
        ramped = min(max(0.0, thrust - thrust_step), thrust + thrust_step)
        return Plan(Phase.LOST, ramped, ramped, azimuth, 0.0, 0.0)
    minimum = limits.thrust_min
    if limits.rotating and limits.may_rotate:
        # T_min = 0 becomes slightly negative, which opens the region about zero; never so far that one step could not
        # come back from it.
        zero_thrust = min(limits.zero_thrust, thrust_step)
        if thrust >= -zero_thrust * (1.0 + _RELEASE_MARGIN):
            lower, upper = step_window(thrust, -zero_thrust, limits.thrust_max, thrust_step, approach)
            if upper > IDLE_SHARE * limits.span:
                turn = min(limits.azimuth_rate * dt, LARGEST_TURN)
                return Plan(Phase.ROTATING, lower, upper, azimuth, -turn, turn)
            # Nothing to direct: a polygon of no size would only trouble the solver.
            return Plan(Phase.FIXED, min(0.0, upper), upper, azimuth, 0.0, 0.0)
        phase = Phase.HELD
        minimum = max(minimum, -zero_thrust)
    elif limits.rotating or not limits.may_rotate:
        phase = Phase.FIXED
    else:
        rest = wrap_angle(limits.fixed_direction - azimuth)
        turn = limits.azimuth_rate * dt
        phase = Phase.FIXED if rest == 0.0 else Phase.TURNING
        if abs(rest) <= turn:
            azimuth = limits.fixed_direction
        else:
            azimuth = wrap_angle(azimuth + (turn if rest > 0.0 else -turn))
    lower, upper = step_window(thrust, minimum, limits.thrust_max, thrust_step, approach)
    return Plan(phase, lower, upper, azimuth, 0.0, 0.0)
