"""quta: sectors as disjunct constraints of thrusters, every combination solved by quadprog."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from benchmarks.peers.peer import PeerMissingError
from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.sectors import vessel_sectors

# quadprog calls feasible problems inconsistent where weights span 1 to 1e8: all are divided by this part of the
# smallest slack weight, which changes no answer.
_SLACK_WEIGHT = 100.0


class EqualProblem:
    """quta on our very sub-problems: its own enumeration and matrices, with our windows and weights.

    Its thrusters take constraints of a user's making, and its allocator is made to be given a cost by deriving from it.

    Parameters
    ----------
    counts
        Number of windows of every thruster: the sub-problems are all combinations.
    """

    def __init__(self, counts: Sequence[int]) -> None:
        self._modules = _import()
        self._counts = list(counts)

    def prepare(self, problems: Sequence[AllocationProblem]) -> Any:
        """Return an allocator of quta for one step: every thruster with its disjunct windows.

        Parameters
        ----------
        problems
            All sub-problems, the last thruster's windows changing first.
        """
        first = problems[0]
        weights = first.weights
        scale = _SLACK_WEIGHT / float(weights.slack.min())
        allocator = self._allocator(weights.thrust * scale, weights.slack * scale)
        for j in range(len(weights.thrust)):
            thruster = self._modules.thruster.Thruster((weights.columns[j, 2, 1], -weights.columns[j, 2, 0]))
            # The last thruster's windows change first from one sub-problem to the next.
            stride = math.prod(self._counts[j + 1 :])
            for i in range(self._counts[j]):
                thruster.add_constraint(self._constraint(*_block(problems[i * stride], j)))
            allocator.add_thruster(thruster)
        return allocator, first.tau

    def solve(self, task: Any) -> Any:
        """Solve every combination; the best, as (variables, what quadprog says)."""
        allocator, tau = task
        return allocator.allocate(tau, relax=True)

    def forces(self, answer: Any) -> FloatArray:
        """Return the Cartesian thrusts of the answer, shape (n, 2), N."""
        return np.asarray(answer[0]).reshape(-1, 2)

    def _allocator(self, thrust: FloatArray, slack: FloatArray) -> Any:
        base = self._modules.allocator.Allocator
        hessian = np.diag(np.concatenate([np.repeat(thrust, 2), slack]))
        nothing = np.zeros(len(hessian))

        class Weighted(base):  # type: ignore[misc, valid-type]
            def problem_formulation(self, relax: bool) -> tuple[FloatArray, FloatArray]:
                return hessian, nothing

        return Weighted()

    def _constraint(self, rows: FloatArray, limits: FloatArray, equations: int) -> Any:
        """Return rows, shape (k, 2), times force >= limits as a constraint of quta; the first ones are equations."""
        base = self._modules.constraints.Constraint

        class Rows(base):  # type: ignore[misc, valid-type]
            def _linearized_constraint(self) -> tuple[FloatArray, FloatArray, int]:
                return rows, limits, equations

        return Rows()


class StaticSectors:
    """quta as it comes: sectors of the full thrust, no rate limits, equal weights, by design; set up once."""

    def __init__(self, vessel: Vessel) -> None:
        modules = _import()
        self._allocator = modules.allocator.MinimizePowerAllocator()
        self._allocator.set_slack_coefficients([vessel.allocator.slack_gain * w for w in vessel.allocator.slack_weight])
        for j, sectors in enumerate(vessel_sectors(vessel)):
            thruster = modules.thruster.Thruster((vessel.lever_x[j], vessel.lever_y[j]))
            if vessel.can_rotate[j]:
                for window in sectors.windows:
                    # One edge a radian or so: five to an arc of 179 deg.
                    thruster.add_constraint(
                        modules.constraints.SectorConstraint(vessel.thrust_max[j], window.start, window.end, edges=1)
                    )
            else:
                angle = float(vessel.fixed_direction[j])
                # To the last digit, or quta takes a direction athwartships for a slanting one.
                direction = np.round([np.cos(angle), np.sin(angle)], 15)
                thruster.add_constraint(
                    modules.constraints.Constraint1D(
                        tuple(vessel.thrust_min[j] * direction), tuple(vessel.thrust_max[j] * direction)
                    )
                )
            self._allocator.add_thruster(thruster)

    def solve(self, tau: FloatArray) -> Any:
        """Solve every combination."""
        return self._allocator.allocate(tau, relax=True)


def _block(problem: AllocationProblem, j: int) -> tuple[FloatArray, FloatArray, int]:
    """Return the limits of thruster ``j`` on its Cartesian thrust as rows >= limits, and how many are equations."""
    k = problem.bounds
    if j in problem.fixed:
        i = problem.fixed.index(j)
        along = problem.B[:2, i]
        rows = np.array([[-along[1], along[0]], along, -along])
        return rows, np.array([0.0, problem.b_lower[i], -problem.b_upper[i]]), 1
    i = problem.rotating.index(j)
    pair = problem.A[:, k + 2 * i : k + 2 * i + 2]
    own = np.flatnonzero(pair.any(axis=1))
    return -pair[own], -problem.b_upper[k + own], 0


def _import() -> SimpleNamespace:
    """Return the modules of the package."""
    try:
        return SimpleNamespace(
            **{name: importlib.import_module(f"quta.{name}") for name in ("allocator", "constraints", "thruster")}
        )
    except ImportError as error:
        raise PeerMissingError(f"quta cannot be imported: {error}") from error
