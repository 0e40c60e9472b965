"""Thrust allocation: which thruster gives what, and in which direction."""

from thrust_allocator.allocator import Allocator
from thrust_allocator.plan.phase import Phase
from thrust_allocator.program.problem import AllocationProblem, Coupling, SlackForm, Weights
from thrust_allocator.program.solution import Residuals, Solution, judge
from thrust_allocator.program.solver import Solver
from thrust_allocator.program.solvers import solver_names
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings, check_settings

__all__ = [
    "AllocationProblem",
    "AllocationResult",
    "Allocator",
    "AllocatorSettings",
    "Coupling",
    "Phase",
    "Residuals",
    "SlackForm",
    "Solution",
    "Solver",
    "Status",
    "Weights",
    "check_settings",
    "judge",
    "solver_names",
]
