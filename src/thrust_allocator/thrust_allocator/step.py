"""One step of the allocation as machine code: plan, build, solve, commands and sums, without a Python object made."""

from __future__ import annotations

from math import cos, sin

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import LOST, ROTATING, Limit, plan_thrusters
from thrust_allocator.plan.polar import commands
from thrust_allocator.plan.polygon import rotating_corners
from thrust_allocator.program.active_set import IntArray, polish, solve

# Compiled functions know plain numbers only.
_SPAN = Limit.SPAN


class Total:
    """Elements of the sums over all thrusters, shape (m + 4,): tau_achieved (m), then these from the end."""

    COST = -4  # (4.10)
    THRUST_COST = -3  # its part without slack
    POWER = -2  # W, (3.11)
    STATIONARITY = -1  # of the solver's answer, relative: see `active_set.polish`
    COUNT = 4


@compiled
def set_polygons(plans: FloatArray, zero_region: float, corners: FloatArray, count: IntArray) -> None:
    """Write what every thruster may give in this step as a convex polygon: ``corners`` (n, 5, 2), ``count`` (n,)."""
    for j in range(len(count)):
        phase, lower, upper, azimuth, low, high = plans[j]
        if phase == LOST:
            count[j] = 0
        elif phase == ROTATING:
            count[j] = rotating_corners(azimuth, low, high, lower, upper, zero_region, corners[j])
        else:
            c, s = cos(azimuth), sin(azimuth)
            corners[j, 0, 0], corners[j, 0, 1] = lower * c, lower * s
            corners[j, 1, 0], corners[j, 1, 1] = upper * c, upper * s
            count[j] = 2


@compiled
def add_up(
    B: FloatArray,
    weight: FloatArray,
    compliance: FloatArray,
    power_factor: FloatArray,
    tau: FloatArray,
    table: FloatArray,
    totals: FloatArray,
) -> None:
    """Write the sums over the thrusters that are not lost into ``totals``, see :class:`Total`.

    Parameters
    ----------
    B, weight, compliance, tau
        As in :func:`active_set.solve`.
    power_factor
        m_j of P = m_j |T|^(3/2), shape (n,).
    table
        Table of commands, shape (n, 5).
    totals
        Overwritten.
    """
    m = len(tau)
    cost = power = 0.0
    for i in range(m):
        totals[i] = 0.0
    for j in range(len(weight)):
        if table[j, 2] == LOST:
            continue
        thrust, azimuth = table[j, 0], table[j, 1]
        force_x, force_y = thrust * cos(azimuth), thrust * sin(azimuth)
        for i in range(m):
            totals[i] += B[j, i, 0] * force_x + B[j, i, 1] * force_y
        cost += weight[j] * thrust * thrust
        power += power_factor[j] * abs(thrust) ** 1.5
    totals[m + 1] = cost
    for i in range(m):
        cost += (tau[i] - totals[i]) ** 2 / compliance[i]
    totals[m] = cost
    totals[m + 2] = power


@compiled
def allocate(
    limits: FloatArray,
    before: FloatArray,
    B: FloatArray,
    weight: FloatArray,
    compliance: FloatArray,
    power_factor: FloatArray,
    tau: FloatArray,
    dt: float,
    approach: float,
    zero_region: float,
    multiplier: FloatArray,
    plans: FloatArray,
    corners: FloatArray,
    count: IntArray,
    force: FloatArray,
    face: IntArray,
    work: FloatArray,
    gradient: FloatArray,
    table: FloatArray,
    totals: FloatArray,
) -> int:
    """Do all of one step; return the number of steps of the solver, -1 where it failed.

    ``limits`` is the table of limits, (n, 14), ``before`` that of the commands of the step before, (n, 5); dt in s;
    ``approach`` is c_1, ``zero_region`` c_2. Arguments are otherwise those of :func:`active_set.solve` and
    :func:`add_up`; from ``plans`` on they are overwritten.
    """
    plan_thrusters(limits, before[:, 0], before[:, 1], dt, approach, plans)
    set_polygons(plans, zero_region, corners, count)
    steps = solve(B, weight, corners, count, compliance, tau, multiplier, force, face, work)
    left = polish(B, weight, corners, count, compliance, tau, multiplier, force, face, work, gradient)
    commands(plans, limits[:, _SPAN], force, table)
    add_up(B, weight, compliance, power_factor, tau, table, totals)
    totals[len(tau) + 3] = left
    return steps
