"""The default: the active-set method of this package, on the polygons of the problem."""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.program.active_set import polish, pull_of, solve
from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.program.solution import Solution, judge
from thrust_allocator.program.solver import Solver

NAME = "active_set"

# Share of the span of a row's right-hand side within which the row counts as active when multipliers are sought.
_ACTIVE = 1e-9


class ActiveSetSolver(Solver):
    """See :mod:`thrust_allocator.program.active_set`. Cannot solve a problem with shared limits."""

    @property
    def name(self) -> str:
        """Name of the solver."""
        return NAME

    def solve(self, problem: AllocationProblem) -> Solution | None:
        """Solve from zero multipliers."""
        if problem.coupling is not None:
            return None
        weights = problem.weights
        corners, count = problem.polygons()
        m = len(problem.tau)
        multiplier, force, face = np.zeros(m), np.zeros((len(count), 2)), np.zeros(len(count), dtype=np.int64)
        what = (weights.columns, weights.thrust, corners, count, 1.0 / weights.slack, problem.tau)
        work = np.zeros((m, m + 1))
        steps = solve(*what, multiplier, force, face, work)
        if steps < 0:
            return None
        polish(*what, multiplier, force, face, work, np.zeros((len(count), 2)))
        return solution_of(problem, force, multiplier, steps)


def solution_of(problem: AllocationProblem, force: FloatArray, multiplier: FloatArray, steps: int) -> Solution:
    """Return an answer of :func:`active_set.solve` as variables and multipliers of the problem, with residuals.

    Parameters
    ----------
    problem
        What was solved.
    force, multiplier, steps
        Cartesian thrusts (n, 2), N; multipliers of the generalized force, (m,); steps it took.
    """
    from scipy.optimize import nnls  # here: its import is slow, and no step of the allocator needs it

    weights, k = problem.weights, problem.bounds
    columns = weights.columns
    z = np.empty(problem.variables)
    multipliers = np.zeros(len(problem.b_upper))
    for i, j in enumerate(problem.fixed):
        azimuth = problem.plans[j, 3]
        c, s = np.cos(azimuth), np.sin(azimuth)
        z[i] = force[j, 0] * c + force[j, 1] * s
        x, y = pull_of(columns, j, multiplier)
        held = c * x + s * y - weights.thrust[j] * z[i]
        if _near(z[i], problem.b_lower[i], problem.b_upper[i]):
            multipliers[i] = held
    for i, j in enumerate(problem.rotating):
        at = k + 2 * i
        z[at : at + 2] = force[j]
        rows = problem.rows[i]
        A = problem.A[rows, at : at + 2]
        limits = problem.b_upper[k:][rows]
        active = np.flatnonzero(limits - A @ force[j] <= _ACTIVE * max(1.0, float(np.abs(limits).max())))
        if len(active):
            held = np.array(pull_of(columns, j, multiplier)) - weights.thrust[j] * force[j]
            multipliers[k + rows.start + active] = nnls(A[active].T, held)[0]
    return Solution(z, multipliers, steps, "", judge(problem, z, multipliers))


def _near(value: float, lower: float, upper: float) -> bool:
    return min(abs(value - lower), abs(value - upper)) <= _ACTIVE * max(1.0, abs(lower), abs(upper))
