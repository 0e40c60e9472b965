"""What each thruster is doing, and what it may do in this step: [Ruth] 4.4.2 and 6.3."""

from __future__ import annotations

from enum import IntEnum

from marine_model.compiled import compiled
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from thrust_allocator.plan.windows import LARGEST_TURN, step_window

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
    CROSSING = 5  # to be rotating, but outside its window: turns to it at full rate, along the direction it passes


# The same as plain numbers, which compiled functions know.
LOST, FIXED, TURNING, HELD, ROTATING, CROSSING = range(6)


class Limit:
    """Columns of the table of limits, shape (n, 14): what settings, vessel and supervisors allow each thruster."""

    ENABLED = 0  # 0 for a lost thruster
    MAY_ROTATE = 1  # 0 for a tunnel thruster or a lost azimuth drive
    ROTATING = 2  # 1 where the azimuth mode asks for a rotating thruster
    THRUST_MIN = 3  # N
    THRUST_MAX = 4  # N
    THRUST_RATE = 5  # N/s
    AZIMUTH_RATE = 6  # rad/s
    DIRECTION = 7  # where the thruster points when held fixed, rad in [-pi, pi)
    ZERO_THRUST = 8  # c_2 (|T_max| + |T_min|), N, [Ruth] 6.3
    SPAN = 9  # |T_max| + |T_min|, N: the size of this thruster, for tolerances
    REACH_LOW = 10  # ends of the window allowed, from the present direction, rad; -inf, inf for the whole circle
    REACH_HIGH = 11
    TO_WINDOW = 12  # turn that brings the thruster into its window, rad; 0 inside
    FACTOR = 13  # share of the largest thrust allowed in the direction where it points
    COLUMNS = 14


class Plan:
    """Columns of the table of plans, shape (n, 6): what each thruster may do in one step.

    A rotating thruster starts from ``AZIMUTH`` and may turn by ``TURN_LOW`` to ``TURN_HIGH`` (rad, 0 between them);
    any other points along ``AZIMUTH`` in this step.
    """

    PHASE = 0
    LOWER = 1  # T_-, N
    UPPER = 2  # T_+, N
    AZIMUTH = 3  # rad in [-pi, pi)
    TURN_LOW = 4
    TURN_HIGH = 5
    COLUMNS = 6


_ENABLED, _MAY_ROTATE, _ROTATING = Limit.ENABLED, Limit.MAY_ROTATE, Limit.ROTATING
_THRUST_MIN, _THRUST_MAX, _THRUST_RATE = Limit.THRUST_MIN, Limit.THRUST_MAX, Limit.THRUST_RATE
_AZIMUTH_RATE, _DIRECTION, _ZERO_THRUST, _SPAN = Limit.AZIMUTH_RATE, Limit.DIRECTION, Limit.ZERO_THRUST, Limit.SPAN
_REACH_LOW, _REACH_HIGH, _TO_WINDOW, _FACTOR = Limit.REACH_LOW, Limit.REACH_HIGH, Limit.TO_WINDOW, Limit.FACTOR

wrap = compiled(wrap_angle)

_Plan = tuple[int, float, float, float, float, float]


@compiled
def plan_thruster(limits: FloatArray, thrust: float, azimuth: float, dt: float, approach: float) -> _Plan:
    """Return what a thruster may do in the next step: one row of the table of plans.

    A switch needs no memory: what a thruster does follows from its limits and its last command. From rotating to
    fixed it turns to its fixed direction at full rate and is allocated as fixed, reverse thrust included, on the way.
    From fixed to rotating it stays fixed where it points, with its least thrust raised to -zero_thrust, until its
    thrust is up there. A rotating thruster outside its window turns to it at full rate, as (4.16)-(4.17) do with
    c_1 = 1, and gives no reverse thrust on the way.

    [Ruth] 6.3 releases it when T_0 is above that limit. A thruster that is wanted the other way round sits exactly on
    the limit and would never be released; here the limit itself counts as reached.

    Parameters
    ----------
    limits
        A row of the table of limits, shape (14,), see :class:`Limit`.
    thrust, azimuth
        Command of the step before: T_0 (N), alpha_0 (rad in [-pi, pi)).
    dt
        Time step, s.
    approach
        c_1.
    """
    thrust_step = limits[_THRUST_RATE] * dt
    if limits[_ENABLED] == 0.0:
        ramped = min(max(0.0, thrust - thrust_step), thrust + thrust_step)
        return LOST, ramped, ramped, azimuth, 0.0, 0.0
    minimum = limits[_THRUST_MIN]
    maximum = limits[_THRUST_MAX] * limits[_FACTOR]
    may_rotate = limits[_MAY_ROTATE] != 0.0
    turn = limits[_AZIMUTH_RATE] * dt
    if limits[_ROTATING] != 0.0 and may_rotate:
        # T_min = 0 becomes slightly negative, which opens the region about zero; never so far that one step could not
        # come back from it.
        zero_thrust = min(limits[_ZERO_THRUST], thrust_step)
        if thrust >= -zero_thrust * (1.0 + _RELEASE_MARGIN):
            rest = limits[_TO_WINDOW]
            if rest != 0.0:
                lower, upper = step_window(thrust, 0.0, maximum, thrust_step, approach)
                return CROSSING, lower, upper, wrap(azimuth + min(max(rest, -turn), turn)), 0.0, 0.0
            lower, upper = step_window(thrust, -zero_thrust, maximum, thrust_step, approach)
            if upper > IDLE_SHARE * limits[_SPAN]:
                turn = min(turn, LARGEST_TURN)
                low, high = max(-turn, limits[_REACH_LOW]), min(turn, limits[_REACH_HIGH])
                return ROTATING, lower, upper, azimuth, min(low, 0.0), max(high, 0.0)
            # Nothing to direct: a polygon of no size would only trouble the solver.
            return FIXED, min(0.0, upper), upper, azimuth, 0.0, 0.0
        phase = HELD
        minimum = max(minimum, -zero_thrust)
    elif limits[_ROTATING] != 0.0 or not may_rotate:
        phase = FIXED
    else:
        direction = limits[_DIRECTION]
        rest = wrap(direction - azimuth)
        phase = FIXED if rest == 0.0 else TURNING
        if abs(rest) <= turn:
            azimuth = direction
        else:
            azimuth = wrap(azimuth + (turn if rest > 0.0 else -turn))
    lower, upper = step_window(thrust, minimum, maximum, thrust_step, approach)
    return phase, lower, upper, azimuth, 0.0, 0.0


@compiled
def plan_thrusters(
    limits: FloatArray, thrust: FloatArray, azimuth: FloatArray, dt: float, approach: float, plans: FloatArray
) -> None:
    """Write what every thruster may do into ``plans``, shape (n, 6); arguments as in :func:`plan_thruster`."""
    for j in range(len(thrust)):
        phase, lower, upper, direction, low, high = plan_thruster(limits[j], thrust[j], azimuth[j], dt, approach)
        plans[j, 0] = phase
        plans[j, 1] = lower
        plans[j, 2] = upper
        plans[j, 3] = direction
        plans[j, 4] = low
        plans[j, 5] = high
