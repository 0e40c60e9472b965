"""The problem with sectors, step by step: all its convex sub-problems, and who picks the best of them for us.

A sub-problem is one window of directions a thruster, [Ruth] 6.4.1; CyberShip III has the 18 of Table 6.1.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from benchmarks.demands import Step
from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from thrust_allocator import AllocatorSettings
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.limits import limit_table
from thrust_allocator.phase import Limit
from thrust_allocator.polar import Command
from thrust_allocator.problem import AllocationProblem
from thrust_allocator.sectors import ThrusterSectors, combinations, factor_at, path_to, vessel_sectors


class SectorAllocator(ABC):
    """Our allocator on the problem with sectors: the cheapest of all sub-problems in every step, without hysteresis."""

    @abstractmethod
    def step(self, tau: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return thrust (N), direction (rad), shape (n,), and slack, shape (3,); timed."""

    @property
    @abstractmethod
    def cost(self) -> float:
        """Cost (4.20) of the program of the sub-problem that the last step chose."""

    @abstractmethod
    def sub_problems(self) -> list[AllocationProblem]:
        """Return all sub-problems of the last step, the windows of the last thruster changing first."""


# CONNECT: return the allocator with its sectors enabled, hysteresis and dwell time zero; `OURS` says in the notes how
# it does it. Everything else in the benchmarks of sectors goes through this function and the class above.
OURS = "every sub-problem solved"


def start(vessel: Vessel) -> SectorAllocator:
    """Return our allocator at its start: thrusters at rest in their fixed directions."""
    return AllSubProblems(vessel)


class AllSubProblems(SectorAllocator):
    """Solves all of them by the compiled step and takes the cheapest.

    Parameters
    ----------
    vessel
        Geometry, limits, weights, sectors.
    """

    def __init__(self, vessel: Vessel) -> None:
        self._vessel = vessel
        self._engine = Engine(vessel)
        self._sectors = vessel_sectors(vessel)
        self._combinations = list(combinations(self._sectors))
        self._limits = limit_table(vessel, AllocatorSettings(azimuth_mode="rotating"))
        self._before = np.zeros((len(vessel.thrusters), Command.COLUMNS))
        self._before[:, Command.AZIMUTH] = vessel.fixed_direction
        self._multiplier = np.zeros(3)
        self._cost = math.inf
        self._answers: list[Answer] = []

    def step(self, tau: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return thrust, direction and slack of the cheapest sub-problem."""
        weights = self._engine.weights
        of_window = [
            [self._row(j, sectors, window) for window in range(len(sectors.windows))]
            for j, sectors in enumerate(self._sectors)
        ]
        self._answers = []
        best: Answer | None = None
        self._cost = math.inf
        for windows in self._combinations:
            limits = np.array([of_window[j][window] for j, window in enumerate(windows)])
            answer = self._engine.run(limits, self._before, self._multiplier, weights.thrust, tau, dt)
            self._answers.append(answer)
            slack = tau - np.einsum("jik,jk->i", self._engine.columns, answer.force)
            cost = float(weights.slack @ slack**2 + weights.thrust @ (answer.force**2).sum(axis=1))
            if not answer.complaint and cost < self._cost:
                best, self._cost = answer, cost
        if best is None:
            raise ValueError("no sub-problem was solved")
        self._before = best.commands
        self._multiplier = best.multiplier
        thrust, azimuth = best.commands[:, Command.THRUST], best.commands[:, Command.AZIMUTH]
        return thrust, azimuth, tau - best.totals[:3]

    @property
    def cost(self) -> float:
        """Cost (4.20) of the chosen program."""
        return self._cost

    def sub_problems(self) -> list[AllocationProblem]:
        """Return all sub-problems of the last step."""
        return [self._engine.problem(answer) for answer in self._answers]

    def _row(self, j: int, sectors: ThrusterSectors, window: int) -> FloatArray:
        """Return the limits of thruster ``j`` for one of its windows."""
        row = np.array(self._limits[j])
        chosen = sectors.windows[window]
        if chosen.disc:
            return row
        azimuth = float(self._before[j, Command.AZIMUTH])
        offset = wrap_angle(azimuth - chosen.centre)
        path = path_to(sectors, window, azimuth)
        row[Limit.REACH_LOW], row[Limit.REACH_HIGH] = -chosen.half_width - offset, chosen.half_width - offset
        row[Limit.TO_WINDOW] = 0.0 if path.inside else path.turn
        row[Limit.FACTOR] = factor_at(sectors, azimuth)
        return row


@dataclass(frozen=True, slots=True)
class SectorStep:
    """One step with sectors: the step as such, and all of its sub-problems."""

    step: Step
    problems: list[AllocationProblem]
    cost: float  # of the program that was chosen


def sub_problems(step: SectorStep) -> list[AllocationProblem]:
    """Return the sub-problems of ``step``, 18 for CyberShip III: what every peer is given."""
    return step.problems


def window_counts(vessel: Vessel) -> list[int]:
    """Return the number of windows of every thruster; the sub-problems are all their combinations."""
    return [len(sectors.windows) for sectors in vessel_sectors(vessel)]


def record_sectors(vessel: Vessel, demands: FloatArray, dt: float) -> list[SectorStep]:
    """Let our allocator answer ``demands``, shape (steps, 3), and keep every sub-problem."""
    allocator = start(vessel)
    thrust, azimuth = np.zeros(len(vessel.thrusters)), vessel.fixed_direction.copy()
    steps: list[SectorStep] = []
    for tau in demands:
        new_thrust, new_azimuth, slack = allocator.step(tau, dt)
        problems = allocator.sub_problems()
        answer = Step(tau, dt, thrust, azimuth, new_thrust.copy(), new_azimuth.copy(), slack.copy(), problems[0])
        steps.append(SectorStep(answer, problems, allocator.cost))
        thrust, azimuth = answer.thrust, answer.azimuth
    return steps
