"""The default: a dual active-set solver on the condensed problem."""

from __future__ import annotations

import daqp

from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.program.solution import Solution, judge
from thrust_allocator.program.solver import Solver

# daqp measures its primal tolerance in the norm that H defines, in which a force weighs as much as in W_u or more:
# 1e-10 is about 1e-10 N. Demands far beyond the vessel are numbers in that norm that are not exact to 1e-10, and daqp
# then takes a problem for infeasible; it gets the wider tolerances. The answer is on the active rows exactly anyway.
_PRIMAL_TOLERANCES = (1e-10, 1e-8, 1e-6)
_OPTIMAL = 1
# What ends the search: N, and relative.
_ACCURATE_FORCE = 1e-9
_ACCURATE_GRADIENT = 1e-8


class DaqpSolver(Solver):
    """daqp (Arnstrom et al. 2022), called with the problem as it stands."""

    @property
    def name(self) -> str:
        """Name of the solver."""
        return "daqp"

    def solve(self, problem: AllocationProblem) -> Solution | None:
        """Solve the condensed form."""
        solution = None
        for tolerance in _PRIMAL_TOLERANCES:
            z, _, flag, information = daqp.solve(
                problem.H, problem.f, problem.A, problem.b_upper, problem.b_lower, primal_tol=tolerance
            )
            multipliers = information["lam"]
            solution = Solution(
                z,
                multipliers,
                int(information["iterations"]),
                "" if flag == _OPTIMAL else f"daqp exit flag {flag}",
                judge(problem, z, multipliers),
            )
            if solution.residuals.within(_ACCURATE_FORCE, _ACCURATE_GRADIENT):
                break
        return solution
