"""From the Cartesian answer back to thrust and direction, with the re-check of [Ruth] 4.4.2."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import CROSSING, IDLE_SHARE, LOST, ROTATING, TURNING, wrap

# Share of a thruster's span, and angle in rad, within which a command counts as being on its limit.
_AT_LIMIT = 1e-7


class Command:
    """Columns of the table of commands, shape (n, 5): what every thruster is told, and how that was found."""

    THRUST = 0  # N
    AZIMUTH = 1  # rad in [-pi, pi)
    PHASE = 2
    THRUST_SATURATED = 3  # at a magnitude or rate limit; a rotating thruster at rest is not
    AZIMUTH_SATURATED = 4  # at an end of its window
    COLUMNS = 5


@compiled
def rotating_command(plan: FloatArray, force_x: float, force_y: float, idle: float) -> tuple[float, float]:
    """Return thrust (N) and direction (rad in [-pi, pi)) of a rotating thruster.

    The direction of the Cartesian answer is brought into the azimuth window the shorter way; the thrust is the part of
    the answer along the direction that comes out, and zero where that part is negative.

    Parameters
    ----------
    plan
        Row of the table of plans, shape (6,).
    force_x, force_y
        Answer of the solver, N.
    idle
        Below this size (N) the answer has no direction, and the thruster stays as near to where it points as its
        window allows.
    """
    _, lower, upper, before, low, high = plan
    turn = 0.0
    if hypot(force_x, force_y) > idle:
        turn = wrap(atan2(force_y, force_x) - before)
    turn = min(max(turn, low), high)
    azimuth = wrap(before + turn)
    thrust = max(force_x * cos(azimuth) + force_y * sin(azimuth), 0.0)
    return min(max(thrust, lower), upper), azimuth


@compiled
def commands(plans: FloatArray, spans: FloatArray, force: FloatArray, table: FloatArray) -> None:
    """Write the table of commands, shape (n, 5), see :class:`Command`.

    Parameters
    ----------
    plans
        Table of plans, shape (n, 6).
    spans
        |T_max| + |T_min|, shape (n,), N.
    force
        Answer of the solver, shape (n, 2), N. Lost thrusters have none; their plan leaves no choice.
    table
        Overwritten.
    """
    for j in range(len(spans)):
        plan = plans[j]
        phase, lower, upper, before, low, high = plan
        near = _AT_LIMIT * spans[j]
        at_thrust = at_azimuth = False
        if phase == ROTATING:
            thrust, azimuth = rotating_command(plan, force[j, 0], force[j, 1], IDLE_SHARE * spans[j])
            turn = wrap(azimuth - before)
            at_azimuth = turn <= low + _AT_LIMIT or turn >= high - _AT_LIMIT
            # The lines (4.41)-(4.42) lie below the arc except at the present direction.
            ends = min(upper * cos(low) / cos(turn - low), upper * cos(high) / cos(turn - high))
            at_thrust = thrust >= ends - near or (lower > 0.0 and thrust <= lower / cos(turn) + near)
        elif phase == LOST:
            thrust, azimuth = lower, before
        else:
            azimuth = before
            thrust = min(max(force[j, 0] * cos(before) + force[j, 1] * sin(before), lower), upper)
            at_thrust = thrust >= upper - near or thrust <= lower + near
            at_azimuth = phase in (TURNING, CROSSING)
        table[j, 0] = thrust
        table[j, 1] = azimuth
        table[j, 2] = phase
        table[j, 3] = at_thrust
        table[j, 4] = at_azimuth
