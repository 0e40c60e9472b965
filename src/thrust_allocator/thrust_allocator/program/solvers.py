"""Solvers by name."""

from __future__ import annotations

from marine_model.errors import InputError
from thrust_allocator.program.active_set_solver import NAME, ActiveSetSolver
from thrust_allocator.program.daqp_solver import DaqpSolver
from thrust_allocator.program.qpsolvers_solver import QpsolversSolver, installed
from thrust_allocator.program.solver import Solver


def solver_names() -> tuple[str, ...]:
    """Return the names that ``settings.solver`` may have on this machine, the default first."""
    return (NAME, "daqp", *installed())


def check_solver(name: str) -> None:
    """Raise InputError if no solver called ``name`` is installed; the message lists those that are."""
    if name not in solver_names():
        raise InputError(f"solver: expected one of {', '.join(solver_names())}, found '{name}'")


def make_solver(name: str) -> Solver:
    """Return the solver called ``name``. Raises InputError."""
    check_solver(name)
    if name == NAME:
        return ActiveSetSolver()
    return DaqpSolver() if name == "daqp" else QpsolversSolver(name)
