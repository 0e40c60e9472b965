"""quta: sectors as disjunct constraints of thrusters, every combination solved by quadprog."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from benchmarks.peers.peer import PeerMissingError
from benchmarks.sub_problems import Windows
from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.problem import AllocationProblem

# quadprog calls feasible problems inconsistent where weights span 1 to 1e8: all are divided by this part of the
# smallest slack weight, which changes no answer.
_SLACK_WEIGHT = 100.0


class EqualProblem:
    """quta on our very sub-problems: its own enumeration and matrices, with our windows and weights.

    Its thrusters take constraints of a user's making, and its allocator is made to be given a cost by deriving from it.

    Parameters
    ----------
    windows
        Of every azimuth thruster: the sub-problems are all combinations.
    """

    def __init__(self, windows: Windows) -> None:
        self._modules = _import()
        self._counts = [len(of_thruster) for of_thruster in windows]

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
        rows = len(first.A) // max(1, len(first.rotating))
        for j in range(len(weights.thrust)):
            thruster = self._modules.thruster.Thruster((weights.lever_x[j], weights.lever_y[j]))
            if j in first.fixed:
                i = first.fixed.index(j)
                direction = np.array([first.B[0, i], first.B[1, i]])
                thruster.add_constraint(
                    self._modules.constraints.Constraint1D(
                        tuple(first.b_lower[i] * direction), tuple(first.b_upper[i] * direction)
                    )
                )
            else:
                at = first.rotating.index(j)
                pair = first.bounds + 2 * at
                # The last thruster's windows change first from one sub-problem to the next.
                stride = math.prod(self._counts[at + 1 :])
                for i in range(self._counts[at]):
                    thruster.add_constraint(self._rows(_block(problems[i * stride], rows * at, rows, pair)))
            allocator.add_thruster(thruster)
        return allocator, first.tau

    def solve(self, task: Any) -> Any:
        """Solve every combination; the best, as (variables, what quadprog says)."""
        allocator, tau = task
        return allocator.allocate(tau, relax=True)

    def variables(self, problem: AllocationProblem, answer: Any) -> FloatArray:
        """Return the answer as variables of ``problem``, shape (m,)."""
        forces = np.asarray(answer[0]).reshape(-1, 2)
        z = [float(forces[j] @ problem.B[:2, i]) for i, j in enumerate(problem.fixed)]
        for j in problem.rotating:
            z += forces[j].tolist()
        return np.array(z)

    def _allocator(self, thrust: FloatArray, slack: FloatArray) -> Any:
        base = self._modules.allocator.Allocator
        hessian = np.diag(np.concatenate([np.repeat(thrust, 2), slack]))
        nothing = np.zeros(len(hessian))

        class Weighted(base):  # type: ignore[misc, valid-type]
            def problem_formulation(self, relax: bool) -> tuple[FloatArray, FloatArray]:
                return hessian, nothing

        return Weighted()

    def _rows(self, block: FloatArray) -> Any:
        """Return rows (a_x, a_y, b), a_x T_x + a_y T_y <= b, as a constraint of quta."""
        base = self._modules.constraints.Constraint

        class Rows(base):  # type: ignore[misc, valid-type]
            def _linearized_constraint(self) -> tuple[FloatArray, FloatArray, int]:
                return -block[:, :2], -block[:, 2], 0

        return Rows()


class StaticSectors:
    """quta as it comes: sectors of the full thrust, no rate limits, equal weights, by design; set up once."""

    def __init__(self, vessel: Vessel, windows: Windows) -> None:
        modules = _import()
        self._allocator = modules.allocator.MinimizePowerAllocator()
        self._allocator.set_slack_coefficients([vessel.allocator.slack_gain * w for w in vessel.allocator.slack_weight])
        of = iter(windows)
        for j, turns in enumerate(vessel.can_rotate):
            thruster = modules.thruster.Thruster((vessel.lever_x[j], vessel.lever_y[j]))
            if turns:
                for window in next(of):
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


def _block(problem: AllocationProblem, first: int, rows: int, pair: int) -> FloatArray:
    """Return the rows of one thruster as (a_x, a_y, b), shape (rows, 3)."""
    bounds = problem.b_upper[problem.bounds + first : problem.bounds + first + rows]
    return np.column_stack([problem.A[first : first + rows, pair : pair + 2], bounds])


def _import() -> SimpleNamespace:
    """Return the modules of the package."""
    try:
        return SimpleNamespace(
            **{name: importlib.import_module(f"quta.{name}") for name in ("allocator", "constraints", "thruster")}
        )
    except ImportError as error:
        raise PeerMissingError(f"quta cannot be imported: {error}") from error
