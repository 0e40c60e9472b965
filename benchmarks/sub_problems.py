"""The 18 convex sub-problems of Table 6.1 of [Ruth], step by step, and who picks the best of them for us."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from benchmarks.demands import Step
from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from thrust_allocator.phase import Phase, Plan
from thrust_allocator.polar import rotating_command
from thrust_allocator.problem import AllocationProblem, Weights
from thrust_allocator.solvers import make_solver
from thrust_allocator.windows import step_window


class Window(NamedTuple):
    """Allowed directions of one thruster, rad: from ``start`` by the positive turn to ``end``, less than 180 deg."""

    start: float
    end: float


def _window(start: float, end: float) -> Window:
    return Window(math.radians(start), math.radians(end))


Windows = tuple[tuple[Window, ...], ...]

# Table 6.1 by rotating thruster: bow, port, starboard. Every combination is a sub-problem, in the table's order.
TABLE_6_1: Windows = (
    (_window(30, 209), _window(-209, -30)),
    (_window(-70, 109), _window(-20, 159), _window(-150, -110)),
    (_window(-109, 70), _window(-159, 20), _window(110, 150)),
)


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
        """Return the sub-problems of the last step, in the order of Table 6.1; copies."""


# CONNECT: return the allocator with its sectors enabled, hysteresis and dwell time zero. Everything else in the
# benchmarks of sectors goes through this function and the class above.
def start(vessel: Vessel, windows: Windows = TABLE_6_1) -> SectorAllocator:
    """Return our allocator at its start: thrusters at rest in their fixed directions.

    Parameters
    ----------
    vessel
        Geometry, limits, weights.
    windows
        Of every azimuth thruster, in the order of the vessel; what no window covers is forbidden.
    """
    return AllSubProblems(vessel, windows)


OURS = "every sub-problem solved"


class AllSubProblems(SectorAllocator):
    """Solves all of them and takes the cheapest.

    Parameters
    ----------
    vessel
        Geometry, limits, weights.
    windows
        Of every azimuth thruster, in the order of the vessel.
    """

    def __init__(self, vessel: Vessel, windows: Windows) -> None:
        self._vessel = vessel
        self._combinations = list(product(*windows))
        self._fixed = [j for j, turns in enumerate(vessel.can_rotate) if not turns]
        self._rotating = [j for j, turns in enumerate(vessel.can_rotate) if turns]
        weights = Weights.of(vessel)
        self._problems = [AllocationProblem(weights, self._fixed, self._rotating) for _ in self._combinations]
        for problem in self._problems:
            problem.point([float(vessel.fixed_direction[j]) for j in self._fixed])
        self._solver = make_solver("daqp")
        self._thrust = np.zeros(len(vessel.thrusters))
        self._azimuth = vessel.fixed_direction.copy()
        self._cost = math.inf

    def step(self, tau: FloatArray, dt: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return thrust, direction and slack of the cheapest sub-problem."""
        plans = [self._plans(windows, dt) for windows in self._combinations]
        best, z = -1, np.zeros(0)
        self._cost = math.inf
        for i, problem in enumerate(self._problems):
            _write(problem, plans[i], tau)
            solution = self._solver.solve(problem)
            cost = math.inf if solution is None else 2.0 * problem.objective(solution.z)
            if solution is not None and cost < self._cost:
                best, z, self._cost = i, solution.z, cost
        problem = self._problems[best]
        thrust, azimuth = self._thrust.copy(), self._azimuth.copy()
        for i, j in enumerate(self._fixed):
            thrust[j] = min(max(z[i], plans[best][j].thrust_lower), plans[best][j].thrust_upper)
        at = len(self._fixed)
        for j in self._rotating:
            thrust[j], azimuth[j] = rotating_command(plans[best][j], z[at], z[at + 1], 1e-6)
            at += 2
        self._thrust, self._azimuth = thrust, azimuth
        return thrust, azimuth, problem.slack(z)

    @property
    def cost(self) -> float:
        """Cost (4.20) of the chosen program."""
        return self._cost

    def sub_problems(self) -> list[AllocationProblem]:
        """Return copies of all."""
        return [problem.copy() for problem in self._problems]

    def _plans(self, windows: Sequence[Window], dt: float) -> list[Plan]:
        """Return what each thruster may do; outside its window it comes nearer at c_1 of its rate or more."""
        vessel = self._vessel
        approach = vessel.allocator.approach_fraction
        plans = []
        of = iter(windows)
        for j, turns in enumerate(vessel.can_rotate):
            change = float(vessel.thrust_rate[j]) * dt
            least, most = float(vessel.thrust_min[j]), float(vessel.thrust_max[j])
            before = float(self._azimuth[j])
            low = high = 0.0
            if turns:
                least = -min(vessel.allocator.zero_region * (most - least), change)
                window = next(of)
                half = 0.5 * (window.end - window.start)
                offset = wrap_angle(before - 0.5 * (window.start + window.end))
                low, high = step_window(offset, -half, half, float(vessel.azimuth_rate[j]) * dt, approach)
                low, high = low - offset, high - offset
            lower, upper = step_window(float(self._thrust[j]), least, most, change, approach)
            plans.append(Plan(Phase.ROTATING if turns else Phase.FIXED, lower, upper, before, low, high))
        return plans


def _write(problem: AllocationProblem, plans: Sequence[Plan], tau: FloatArray) -> None:
    for i, j in enumerate(problem.fixed):
        problem.limit_fixed(i, plans[j].thrust_lower, plans[j].thrust_upper)
    for i, j in enumerate(problem.rotating):
        _, lower, upper, azimuth, low, high = plans[j]
        problem.limit_rotating(i, azimuth, low, high, lower, upper)
    problem.demand(tau)


@dataclass(frozen=True, slots=True)
class SectorStep:
    """One step with sectors: the step as such, with the cheapest problem, and all of the sub-problems."""

    step: Step
    problems: list[AllocationProblem]
    cost: float  # of the problem that was chosen


def sub_problems(step: SectorStep) -> list[AllocationProblem]:
    """Return the 18 sub-problems of ``step``: what every peer is given."""
    return step.problems


def record_sectors(vessel: Vessel, demands: FloatArray, dt: float, windows: Windows = TABLE_6_1) -> list[SectorStep]:
    """Let our allocator answer ``demands``, shape (steps, 3), and keep every sub-problem."""
    allocator = start(vessel, windows)
    thrust, azimuth = np.zeros(len(vessel.thrusters)), vessel.fixed_direction.copy()
    steps: list[SectorStep] = []
    for tau in demands:
        new_thrust, new_azimuth, slack = allocator.step(tau, dt)
        problems = allocator.sub_problems()
        answer = Step(tau, dt, thrust, azimuth, new_thrust.copy(), new_azimuth.copy(), slack.copy(), problems[0])
        steps.append(SectorStep(answer, problems, allocator.cost))
        thrust, azimuth = answer.thrust, answer.azimuth
    return steps


def even_windows(vessel: Vessel, count: int) -> Windows:
    """Return ``count`` windows for each azimuth thruster, evenly about its fixed direction, 20 deg apart."""
    gap = math.radians(20.0)
    half = 0.5 * (min(2.0 * math.pi / count, math.pi) - gap)
    centres = [float(angle) for angle, turns in zip(vessel.fixed_direction, vessel.can_rotate, strict=True) if turns]
    shifts = [2.0 * math.pi * i / count for i in range(count)]
    return tuple(tuple(Window(c + shift - half, c + shift + half) for shift in shifts) for c in centres)
