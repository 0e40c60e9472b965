"""Other solvers, through qpsolvers, on the slack form."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.program.solution import Solution, judge
from thrust_allocator.program.solver import Solver


@dataclass(frozen=True, slots=True)
class _Recipe:
    """What makes a solver accurate on this problem: kind of matrix, and options."""

    sparse: bool
    options: Mapping[str, Any]


# Solvers whose answers were found accurate; what was measured is in docs/thrust_allocator.md.
RECIPES: Mapping[str, _Recipe] = {
    "clarabel": _Recipe(True, {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-12}),
    "osqp": _Recipe(True, {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 20_000, "polishing": True}),
    "piqp": _Recipe(False, {"eps_abs": 1e-12, "eps_rel": 1e-12}),
    "quadprog": _Recipe(False, {}),
}


def installed() -> tuple[str, ...]:
    """Return the solvers of :data:`RECIPES` that qpsolvers finds on this machine, sorted."""
    try:
        import qpsolvers
    except ImportError:
        return ()
    return tuple(sorted(set(qpsolvers.available_solvers) & set(RECIPES)))


class QpsolversSolver(Solver):
    """One of :data:`RECIPES`.

    Parameters
    ----------
    name
        Name in qpsolvers; must be installed.
    """

    def __init__(self, name: str) -> None:
        import qpsolvers

        self._qpsolvers = qpsolvers
        self._name = name
        self._recipe = RECIPES[name]

    @property
    def name(self) -> str:
        """Name of the solver."""
        return self._name

    def solve(self, problem: AllocationProblem) -> Solution | None:
        """Solve the slack form; judged on the condensed form, as every answer is."""
        recipe = self._recipe
        form = problem.slack_form()
        P, G, E = form.P, form.G, form.E
        if recipe.sparse:
            from scipy.sparse import csc_matrix

            P, G, E = csc_matrix(P), csc_matrix(G), csc_matrix(E)
        rows = len(form.h) > 0
        program = self._qpsolvers.Problem(
            P,
            np.zeros(len(form.lower)),
            G if rows else None,
            form.h if rows else None,
            E,
            form.tau,
            form.lower,
            form.upper,
        )
        # Whatever a solver raises or warns of, the step needs an answer: without one the allocator holds.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                found = self._qpsolvers.solve_problem(program, solver=self._name, **recipe.options)
            except Exception:
                return None
        if found.x is None or found.z_box is None:
            return None
        m, k = problem.variables, problem.bounds
        z = np.asarray(found.x[:m], dtype=np.float64)
        # The rows have no lower limit: a multiplier of the wrong sign belongs to nothing, and shows as stationarity.
        of_rows = np.maximum(found.z, 0.0) if rows else np.zeros(0)
        multipliers = np.concatenate((found.z_box[:k], of_rows)) / form.scale
        return Solution(
            z,
            multipliers,
            int(found.extras.get("iter", -1)) if found.extras else -1,
            "" if found.found else f"{self._name} found no solution",
            judge(problem, z, multipliers),
        )
