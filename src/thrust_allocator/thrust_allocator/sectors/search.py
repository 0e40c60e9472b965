"""The best combination of windows: the global optimum of all sub-problems, found without solving all.

Any multipliers lambda of the generalized force bound the cost of every combination from below, by duality,

    J >= 2 (lambda' tau - lambda' Q^-1 lambda / 2 - sum_j phi_j),
    phi_j = max over the polygon of p'u - w_j |u|^2 / 2,   p = B_j' lambda,

and phi_j needs the window of thruster j alone. So few evaluations bound all combinations; at the
multipliers of a combination that has been solved its own bound is its cost. A combination is solved only if no set of
multipliers found so far rules it out.
"""

from __future__ import annotations

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.program.active_set import IntArray, pull_of, solve
from thrust_allocator.program.projection import project
from thrust_allocator.sectors.supervisor import limits_of_cost

# Sets of multipliers that are kept; the last ones replace the last place.
_POOL = 24
# Share of a cost that is rounding.
_SAME_COST = 1e-10
# Share of the cost of full thrust that is nothing: without a demand costs are rounding, and their ratio means nothing.
_NOTHING = 1e-18
# Rounding of a bound, as a share of the numbers it is summed from.
_ROUNDING = 1e-13


@compiled
def sub_problem_cost(
    B: FloatArray,
    weight: FloatArray,
    compliance: FloatArray,
    tau: FloatArray,
    corners: FloatArray,
    count: IntArray,
    first: IntArray,
    choice: IntArray,
    multiplier: FloatArray,
    force: FloatArray,
) -> float:
    """Return the cost (4.20) of the combination ``choice`` (n,) of windows; infinity if the solver failed.

    ``corners``, ``count`` and ``first`` are those of :class:`pieces.Pieces`. ``multiplier`` (m,) is where the solver
    starts, and receives the answer's; ``force`` (n, 2) receives the thrusts, N.
    """
    m, n = len(tau), len(weight)
    chosen, counts = np.empty((n, corners.shape[1], 2)), np.empty(n, dtype=np.int64)
    for j in range(n):
        row = first[j] + choice[j]
        counts[j] = count[row]
        for k in range(count[row]):
            chosen[j, k, 0], chosen[j, k, 1] = corners[row, k, 0], corners[row, k, 1]
    face, work = np.empty(n, dtype=np.int64), np.empty((m, m + 1))
    if solve(B, weight, chosen, counts, compliance, tau, multiplier, force, face, work) < 0:
        return np.inf
    cost = 0.0
    for j in range(n):
        cost += weight[j] * (force[j, 0] ** 2 + force[j, 1] ** 2)
    for i in range(m):
        slack = tau[i]
        for j in range(n):
            slack -= B[j, i, 0] * force[j, 0] + B[j, i, 1] * force[j, 1]
        cost += slack * slack / compliance[i]
    return cost


@compiled
def _support(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    first: IntArray,
    reach: IntArray,
    furthest: int,
    multiplier: FloatArray,
    support: FloatArray,
    rest: FloatArray,
) -> float:
    """Write phi of every admissible window, and the sum over later thrusters of the largest; return their size."""
    n = len(weight)
    rest[n] = 0.0
    size = 0.0
    for j in range(n - 1, -1, -1):
        x, y = pull_of(B, j, multiplier)
        largest = -np.inf
        for row in range(first[j], first[j + 1]):
            if reach[row] > furthest:
                continue
            value = 0.0
            if count[row] > 0:
                u_x, u_y, _ = project(corners[row], count[row], x / weight[j], y / weight[j])
                value = x * u_x + y * u_y - 0.5 * weight[j] * (u_x * u_x + u_y * u_y)
            support[row] = value
            largest = max(largest, value)
        rest[j] = rest[j + 1] + largest
        size += abs(largest)
    return size


@compiled
def best_combination(
    B: FloatArray,
    weight: FloatArray,
    compliance: FloatArray,
    tau: FloatArray,
    corners: FloatArray,
    count: IntArray,
    first: IntArray,
    reach: IntArray,
    furthest: int,
    limit: float,
    multiplier: FloatArray,
    choice: IntArray,
) -> tuple[float, int]:
    """Return the least cost below ``limit`` of all admissible combinations, or ``limit``, and how many were solved.

    Parameters
    ----------
    B, weight, compliance, tau
        As in :func:`active_set.solve`.
    corners, count, first
        As of :class:`pieces.Pieces`.
    reach
        Of every window, shape (M,), see :class:`path.Reach`; those above ``furthest`` are left out.
    furthest
        Largest reach admitted.
    limit
        What a combination must cost less than.
    multiplier
        Of a combination that has been solved, shape (m,); not changed.
    choice
        Receives the best combination, shape (n,); unchanged if there is none.
    """
    m, n = len(tau), len(weight)
    pool, base = np.empty((_POOL, m)), np.empty(_POOL)
    support, rest = np.empty((_POOL, len(count))), np.empty((_POOL, n + 1))
    partial = np.empty((_POOL, n + 1))
    at, found, force = np.empty(n, dtype=np.int64), np.empty(m), np.empty((n, 2))
    kept = solved = 0
    found[:] = multiplier
    best = limit
    depth = -1
    while True:
        # Another set of multipliers: what it says of every window.
        if kept < _POOL:
            kept += 1
        last = kept - 1
        pool[last] = found
        size = _support(B, weight, corners, count, first, reach, furthest, found, support[last], rest[last])
        value = 0.0
        for i in range(m):
            value += found[i] * tau[i] - 0.5 * compliance[i] * found[i] * found[i]
            size += abs(found[i] * tau[i])
        base[last] = value - _ROUNDING * size
        if depth < 0:
            for k in range(kept):
                partial[k, 0] = 0.0
            depth = 0
            if n > 0:
                at[0] = first[0] - 1
        else:
            # It has a say on the branch that is being searched, too.
            partial[last, 0] = 0.0
            for j in range(depth + 1):
                partial[last, j + 1] = partial[last, j] + support[last, at[j]]
        leaf = False
        while depth >= 0:
            at[depth] += 1
            if at[depth] >= first[depth + 1]:
                depth -= 1
                continue
            row = at[depth]
            if reach[row] > furthest:
                continue
            hopeless = False
            for k in range(kept):
                partial[k, depth + 1] = partial[k, depth] + support[k, row]
                if 2.0 * (base[k] - partial[k, depth + 1] - rest[k, depth + 1]) >= best:
                    hopeless = True
            if hopeless:
                continue
            if depth + 1 < n:
                depth += 1
                at[depth] = first[depth] - 1
                continue
            leaf = True
            break
        if not leaf:
            return best, solved
        pick = np.empty(n, dtype=np.int64)
        for j in range(n):
            pick[j] = at[j] - first[j]
        found[:] = pool[0]
        cost = sub_problem_cost(B, weight, compliance, tau, corners, count, first, pick, found, force)
        solved += 1
        if cost < best:
            best = cost
            choice[:] = pick


@compiled
def survey(
    B: FloatArray,
    weight: FloatArray,
    compliance: FloatArray,
    tau: FloatArray,
    corners: FloatArray,
    count: IntArray,
    first: IntArray,
    reach: IntArray,
    cost_ratio: float,
    crossing: bool,
    multiplier: FloatArray,
    chosen: IntArray,
    free: IntArray,
    far: IntArray,
) -> tuple[float, float, float, int, int]:
    """Return what the supervisor decides on: the cost of the present combination, and of the best two kinds of others.

    Parameters
    ----------
    B, weight, compliance, tau, corners, count, first, reach
        As in :func:`best_combination`.
    cost_ratio, crossing
        Hysteresis, and whether the dwell time is over, as in :func:`supervisor.limits_of_cost`.
    multiplier
        Where the solver starts; receives the answer's of the present combination, shape (m,).
    chosen
        Present combination, shape (n,).
    free, far
        Receive the best combination that needs no turn, and the best that needs one.

    Returns
    -------
    tuple
        Cost of ``chosen``, of ``free`` and of ``far`` (infinite where there is none that is worth it), the largest
        reach of ``far``, and how many combinations were solved.
    """
    n = len(weight)
    force = np.empty((n, 2))
    cost = sub_problem_cost(B, weight, compliance, tau, corners, count, first, chosen, multiplier, force)
    full = 0.0
    for j in range(n):
        row = first[j] + chosen[j]
        if count[row] > 0:
            last = count[row] - 1
            full += weight[j] * (corners[row, last, 0] ** 2 + corners[row, last, 1] ** 2)
    if cost <= _NOTHING * full:
        return cost, np.inf, np.inf, 0, 1
    limit, _, _ = limits_of_cost(cost, cost_ratio, crossing)
    free_cost, more = best_combination(
        B, weight, compliance, tau, corners, count, first, reach, 0, limit, multiplier, free
    )
    solved = 1 + more
    if free_cost < limit:
        least = free_cost
    else:
        free_cost, least = np.inf, cost
    _, limit, crossing_limit = limits_of_cost(least, cost_ratio, crossing)
    furthest = 2 if crossing_limit >= limit else 1
    far_cost, more = best_combination(
        B, weight, compliance, tau, corners, count, first, reach, furthest, limit, multiplier, far
    )
    if not far_cost < limit:
        return cost, free_cost, np.inf, 0, solved + more
    # Two windows that overlap may cost the same: no thruster is turned to another one for nothing.
    found = np.empty(len(multiplier))
    for j in range(n):
        there = far[j]
        if reach[first[j] + there] == 0:
            continue
        for window in range(first[j + 1] - first[j]):
            if reach[first[j] + window] != 0:
                continue
            far[j] = window
            found[:] = multiplier
            more += 1
            same = sub_problem_cost(B, weight, compliance, tau, corners, count, first, far, found, force)
            if same <= far_cost * (1.0 + _SAME_COST):
                break
            far[j] = there
    hardest = 0
    for j in range(n):
        hardest = max(hardest, reach[first[j] + far[j]])
    return cost, free_cost, far_cost, hardest, solved + more
