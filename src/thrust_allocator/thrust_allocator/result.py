"""How one demand was answered."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from marine_model.guards import FloatArray
from thrust_allocator.phase import Phase
from thrust_allocator.problem import AllocationProblem
from thrust_allocator.solution import Solution


class Status(StrEnum):
    """Which rule gave the answer."""

    OPTIMAL = "optimal"
    # Every thruster is lost: there is nothing to allocate.
    NO_THRUSTER = "no_thruster"
    # The demand was not finite: the last good one was allocated, or zero before the first.
    DEMAND_NOT_FINITE = "demand_not_finite"
    # The solver gave no good answer: thrusts and directions stay, as far as their windows allow.
    HOLD = "hold"


@dataclass(frozen=True, slots=True)
class AllocationResult:
    """Answer of :meth:`Allocator.step`. Arrays over thrusters have shape (n,) and the order of the vessel file.

    Attributes
    ----------
    thrust, azimuth
        Commands: N along the direction; rad in [-pi, pi), body frame.
    tau_desired
        The demand that was allocated, shape (3,), N, N, N m; differs from the argument where that was not finite.
    tau_achieved
        B(azimuth) thrust over the thrusters that are not lost, shape (3,).
    slack
        tau_desired - tau_achieved, shape (3,).
    cost
        Value of (4.10) at the commands, thrusters that are not lost.
    solve_time
        Time this step took from demand to answer, s.
    status
        Which rule gave the answer.
    message
        Why it was not the usual one; empty otherwise.
    azimuth_mode, solver
        Settings in force.
    demanded_power
        Propeller power of the commanded thrusts by (3.11), thrusters that are not lost, W.
    phase
        What every thruster was doing.
    rotating
        Allocated as rotating.
    thrust_saturated
        Thrust at a magnitude or rate limit; a rotating thruster at rest is not.
    azimuth_saturated
        Direction at an end of its window.
    problem, solution
        On a failure the problem and what the solver made of it, for debugging; None otherwise.
    """

    thrust: FloatArray
    azimuth: FloatArray
    tau_desired: FloatArray
    tau_achieved: FloatArray
    slack: FloatArray
    cost: float
    solve_time: float
    status: Status
    message: str
    azimuth_mode: str
    solver: str
    demanded_power: float
    phase: tuple[Phase, ...]
    rotating: tuple[bool, ...]
    thrust_saturated: tuple[bool, ...]
    azimuth_saturated: tuple[bool, ...]
    problem: AllocationProblem | None
    solution: Solution | None
