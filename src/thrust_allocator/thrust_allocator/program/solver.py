"""What every solver of the allocation problem offers."""

from __future__ import annotations

from abc import ABC, abstractmethod

from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.program.solution import Solution


class Solver(ABC):
    """Solves one allocation problem after another."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the solver, as in the settings."""

    @abstractmethod
    def solve(self, problem: AllocationProblem) -> Solution | None:
        """Return the answer with its residuals; None where the solver gave none at all. Never raises."""
