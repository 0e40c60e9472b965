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
from marine_model.guards import FloatArray
from thrust_allocator import Allocator, AllocatorSettings
from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.sectors import vessel_sectors
from thrust_allocator.settings import SectorSettings


class SectorAllocator(ABC):
    """Our allocator on the problem with sectors: the cheapest of all sub-problems in every step, without hysteresis."""

    @abstractmethod
    def step(self, tau: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return thrust (N), direction (rad), shape (n,), and slack, shape (3,); timed."""

    @abstractmethod
    def optimum(self, tau: FloatArray) -> float:
        """Return the least cost of all sub-problems; timed."""

    @property
    @abstractmethod
    def cost(self) -> float:
        """Cost (4.20) of the program of the sub-problem that the last step chose."""

    @abstractmethod
    def sub_problems(self) -> list[AllocationProblem]:
        """Return all sub-problems of the last step, the windows of the last thruster changing first."""


# How ours does it, for the notes.
OURS = "all of one step of the allocator: search, plan, solve, polar form, status"


def start(vessel: Vessel) -> SectorAllocator:
    """Return our allocator at its start: thrusters at rest in their fixed directions."""
    return OurSectors(vessel)


class OurSectors(SectorAllocator):
    """The allocator with sectors, hysteresis and dwell time zero, so that it takes the cheapest in every step.

    Parameters
    ----------
    vessel
        Geometry, limits, weights, sectors.
    """

    def __init__(self, vessel: Vessel) -> None:
        sectors = SectorSettings(enabled=True, hysteresis=0.0, dwell_time=0.0)
        settings = AllocatorSettings.for_vessel(vessel, azimuth_mode="rotating", sectors=sectors)
        self._allocator = Allocator(vessel, settings)
        self._cost = math.inf

    def step(self, tau: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return thrust, direction and slack of one step."""
        result = self._allocator.step(tau, dt)
        if result.sectors is None:
            raise ValueError("the allocator does not keep the sectors")
        self._cost = result.sectors.cost
        return result.thrust, result.azimuth, result.slack

    def optimum(self, tau: FloatArray) -> float:
        """Return the least cost of all sub-problems."""
        return self._allocator.cheapest_windows(tau)[0]

    @property
    def cost(self) -> float:
        """Cost (4.20) of the sub-problem that the last step chose."""
        return self._cost

    def sub_problems(self) -> list[AllocationProblem]:
        """Return all sub-problems of the last step."""
        return self._allocator.sub_problems()


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
