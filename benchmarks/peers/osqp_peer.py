"""OSQP, called anew each step through qpsolvers, or natively: set up once, updated, started from the last answer."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy import sparse

from benchmarks.demands import Step
from benchmarks.peers.natural_form import NaturalForm, natural_form
from benchmarks.peers.peer import Commands, Peer, PeerMissingError, polar_form, titled
from thrust_allocator.program.problem import AllocationProblem

# With the default of 1e-3, forces are wrong by tenths of a newton. These are wrong by thousandths of a newton at most,
# and time has to be spent for that: a smaller tolerance makes more steps end at the limit of iterations.
FAIR: Mapping[str, Any] = MappingProxyType({"eps_abs": 1e-6, "eps_rel": 1e-6, "max_iter": 20_000, "polishing": True})
DEFAULT: Mapping[str, Any] = MappingProxyType({})

_SOLVED = 1  # OSQP_SOLVED; "solved inaccurate" and the limit of iterations are failures


class OsqpThroughQpsolvers(Peer):
    """What most Python users would write: one call of qpsolvers a step, on sparse matrices.

    Parameters
    ----------
    fair
        With :data:`FAIR` accuracy; the defaults of the packages otherwise.
    """

    def __init__(self, fair: bool = True) -> None:
        try:
            import qpsolvers
        except ImportError as error:
            raise PeerMissingError(f"qpsolvers cannot be imported: {error}") from error
        if "osqp" not in qpsolvers.available_solvers:
            raise PeerMissingError("qpsolvers finds no osqp")
        self._qpsolvers = qpsolvers
        self._fair = fair
        self._options = dict(FAIR if fair else DEFAULT)

    @property
    def name(self) -> str:
        """Stable name."""
        return "osqp_qpsolvers" if self._fair else "osqp_qpsolvers_default"

    @property
    def title(self) -> str:
        """What it is."""
        accuracy = "eps 1e-6, polished" if self._fair else "default accuracy"
        return f"{titled('osqp')} through {titled('qpsolvers')}, {accuracy}"

    def prepare(self, step: Step) -> Any:
        """Return the sparse problem."""
        return self.program(step.problem)

    def program(self, problem: AllocationProblem) -> Any:
        """Return ``problem`` as an object of qpsolvers."""
        form = natural_form(problem)
        rows = len(form.h) > 0
        return self._qpsolvers.Problem(
            sparse.csc_matrix(form.P),
            np.zeros(len(form.lower)),
            sparse.csc_matrix(form.G) if rows else None,
            form.h if rows else None,
            sparse.csc_matrix(form.E),
            form.tau,
            form.lower,
            form.upper,
        )

    def solve(self, task: Any) -> Any:
        """Solve one program."""
        return self._qpsolvers.solve_problem(task, solver="osqp", **self._options)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return the commands of an answer that was found."""
        if not answer.found or answer.x is None:
            return None
        return polar_form(step, np.asarray(answer.x[: step.problem.variables]))


class NativeOsqp(Peer):
    """OSQP's own interface: set up at the first step, then updated and started from the last answer."""

    def __init__(self) -> None:
        try:
            import osqp
        except ImportError as error:
            raise PeerMissingError(f"osqp cannot be imported: {error}") from error
        self._osqp = osqp
        self._solver: Any = None
        self._layout: tuple[tuple[int, ...], tuple[int, ...]] | None = None

    @property
    def name(self) -> str:
        """Stable name."""
        return "osqp_native"

    @property
    def title(self) -> str:
        """What it is."""
        return f"{titled('osqp')} itself, updated and started warm, eps 1e-6, polished"

    def prepare(self, step: Step) -> Any:
        """Return matrix values and limits; set up when the form of the problem changes."""
        problem = step.problem
        matrix, lower, upper = _rows(natural_form(problem))
        layout = problem.fixed, problem.rotating
        if layout != self._layout:
            form = natural_form(problem)
            self._solver = self._osqp.OSQP()
            self._solver.setup(
                sparse.csc_matrix(form.P), np.zeros(len(form.P)), matrix, lower, upper, verbose=False, **FAIR
            )
            self._layout = layout
        return matrix.data, lower, upper

    def solve(self, task: Any) -> Any:
        """Update and solve."""
        values, lower, upper = task
        self._solver.update(l=lower, u=upper, Ax=values)
        return self._solver.solve(raise_error=False)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return the commands of an answer that was found."""
        if answer.info.status_val != _SOLVED:
            return None
        return polar_form(step, np.asarray(answer.x[: step.problem.variables]))


def _rows(form: NaturalForm) -> tuple[Any, Any, Any]:
    """Return all constraints as lower <= A x <= upper; A has one pattern whatever its values are."""
    size = len(form.lower)
    bounded = np.flatnonzero(np.isfinite(form.lower) | np.isfinite(form.upper))
    dense = np.vstack([form.E, form.G, np.eye(size)[bounded]])
    # Entries that are zero by chance stay in the pattern: those of the equations, and of the pairs in the rows.
    pattern = dense != 0.0
    pattern[:3, : size - 3] = True
    rows = len(form.E)
    for i in range(len(form.G)):
        pattern[rows + i, _pair(form, i)] = True
    columns, at = np.nonzero(pattern.T)
    matrix = sparse.csc_matrix((dense[at, columns], (at, columns)), shape=dense.shape)
    matrix.sort_indices()
    lower = np.concatenate([form.tau, np.full(len(form.h), -np.inf), form.lower[bounded]])
    upper = np.concatenate([form.tau, form.h, form.upper[bounded]])
    return matrix, lower, upper


def _pair(form: NaturalForm, row: int) -> list[int]:
    """Return the two variables that a row of a rotating thruster is about."""
    first = int(np.flatnonzero(form.G[row])[0])
    free = np.flatnonzero(~np.isfinite(form.lower))
    at = int(np.searchsorted(free, first)) // 2 * 2
    return [int(free[at]), int(free[at + 1])]
