"""From the Cartesian answer back to thrust and direction, with the re-check of [Ruth] 4.4.2."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

from marine_model.frames import wrap_angle
from thrust_allocator.phase import Plan


def rotating_command(plan: Plan, force_x: float, force_y: float, idle: float) -> tuple[float, float]:
    """Return thrust (N) and direction (rad in [-pi, pi)) of a rotating thruster.

    The direction of the Cartesian answer is brought into the azimuth window the shorter way; the thrust is the part of
    the answer along the direction that comes out, and zero where that part is negative.

    Parameters
    ----------
    plan
        Plan of the thruster for this step.
    force_x, force_y
        Answer of the solver, N.
    idle
        Below this size (N) the answer has no direction, and the thruster stays as near to where it points as its
        window allows.
    """
    turn = 0.0
    if hypot(force_x, force_y) > idle:
        turn = wrap_angle(atan2(force_y, force_x) - plan.azimuth)
    turn = min(max(turn, plan.turn_low), plan.turn_high)
    azimuth = wrap_angle(plan.azimuth + turn)
    thrust = max(force_x * cos(azimuth) + force_y * sin(azimuth), 0.0)
    return min(max(thrust, plan.thrust_lower), plan.thrust_upper), azimuth


def held_command(plan: Plan, thrust: float) -> tuple[float, float]:
    """Return thrust and direction that change as little as the windows allow from ``thrust`` (N)."""
    if plan.turn_low < plan.turn_high:
        return rotating_command(plan, thrust * cos(plan.azimuth), thrust * sin(plan.azimuth), 0.0)
    return min(max(thrust, plan.thrust_lower), plan.thrust_upper), plan.azimuth
