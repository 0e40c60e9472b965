"""The default: a dual active-set solver on the condensed problem."""

from __future__ import annotations

import daqp
import numpy as np

from thrust_allocator.problem import AllocationProblem
from thrust_allocator.solution import Solution, judge
from thrust_allocator.solver import Solver

# daqp measures its tolerances in the norm that H defines, in which 1 N is up to gamma W_v: the defaults of 1e-6 are
# 1e-6 N for a thruster that nothing but W_u weighs.
_PRIMAL_TOLERANCE = 1e-10
_DUAL_TOLERANCE = 1e-12
_OPTIMAL = 1


class DaqpSolver(Solver):
    """daqp (Arnstrom et al. 2022), called with the problem as it stands."""

    @property
    def name(self) -> str:
        """Name of the solver."""
        return "daqp"

    def solve(self, problem: AllocationProblem) -> Solution | None:
        """Solve the condensed form."""
        z, _, flag, information = daqp.solve(
            problem.H,
            problem.f,
            problem.A,
            problem.b_upper,
            problem.b_lower,
            primal_tol=_PRIMAL_TOLERANCE,
            dual_tol=_DUAL_TOLERANCE,
        )
        multipliers = information["lam"]
        return Solution(
            z,
            multipliers,
            int(information["iterations"]),
            "" if flag == _OPTIMAL else f"daqp exit flag {flag}",
            judge(problem, np.asarray(z), multipliers),
        )
