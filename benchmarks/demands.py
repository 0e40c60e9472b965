"""Demands as a controller in waves asks for them, and the steps of the allocator that answers them.

Every comparison of the allocator uses these sequences: a slowly changing part (wind, current, mean drift, integral
action), and a part at the frequency of the waves that the observer lets through. The share of saturated steps is
chosen, and the amplitude follows from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator import Allocator, AllocatorSettings
from thrust_allocator.program.problem import AllocationProblem

SATURATED_SHARE = 1.0 / 3.0

_SLOW_PERIODS = (15.0, 120.0)  # s at model scale: drift of wind, current and slowly varying wave forces
_WAVE_BAND = (0.7, 1.4)  # of the wave frequency that the observer is tuned to
_COMPONENTS = 12  # sines of each part; so many that the sum does not repeat within a sequence
_WAVE_SHARE = 0.25  # standard deviation of the wave-frequency part over that of the slow one
# Demand by axis over the sum of all thrust, the yaw one over that times the longest arm, at amplitude 1 (one standard
# deviation): station keeping in seas from ahead and port. Where the mean is smaller, rotating thrusters
# reverse with every wave, and a third of the steps is saturated however small the demand is.
_BY_AXIS = (0.15, 0.08, 0.03)
_MEAN = (-0.30, 0.15, 0.02)
# A step is saturated if limits keep this share of all thrust, or more, from the demand. Without saturation the slack
# is about 1e-6 of the demand at gamma = 1000.
_MISSED = 1e-4
_HALVINGS = 9
_LARGEST_AMPLITUDE = 4.0


# From demand (shape (3,)) and time step (s) to slack (shape (3,)).
Answer = Callable[[FloatArray, float], FloatArray]


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the allocator, with all that another method needs to be given the same task.

    Attributes
    ----------
    tau, dt
        Demand, shape (3,), N, N, N m; time since the last step, s.
    thrust_before, azimuth_before
        Command of the step before, shape (n,), N and rad.
    thrust, azimuth
        The allocator's answer, shape (n,).
    slack
        What it could not give, shape (3,).
    problem
        The quadratic program of this step.
    """

    tau: FloatArray
    dt: float
    thrust_before: FloatArray
    azimuth_before: FloatArray
    thrust: FloatArray
    azimuth: FloatArray
    slack: FloatArray
    problem: AllocationProblem


@dataclass(frozen=True, slots=True)
class DemandSequence:
    """Demands in their order, and how much they ask for."""

    demands: FloatArray  # shape (steps, 3)
    dt: float
    amplitude: float
    saturated: float  # share of the steps


def strength(vessel: Vessel) -> FloatArray:
    """Return the sum of all thrust (N), twice, and that times the longest arm (N m): shape (3,)."""
    total = float(vessel.thrust_max.sum())
    arm = float(max(np.abs(vessel.lever_x).max(), np.abs(vessel.lever_y).max()))
    return np.array([total, total, total * arm])


def demand_in_waves(vessel: Vessel, steps: int, seed: int) -> FloatArray:
    """Return demands at amplitude 1, shape (steps, 3), N, N, N m, one a sample of ``vessel``."""
    draw = np.random.default_rng(seed)
    time = vessel.measurement.sample_time * np.arange(steps)
    columns = []
    for axis, (mean, size, full) in enumerate(zip(_MEAN, _BY_AXIS, strength(vessel), strict=True)):
        slow = 2.0 * math.pi / by_decades(draw, _SLOW_PERIODS, (_COMPONENTS,))
        waves = vessel.observer.wave_frequency[axis] * draw.uniform(*_WAVE_BAND, size=_COMPONENTS)
        phases = draw.uniform(0.0, 2.0 * math.pi, (2, _COMPONENTS, 1))
        # Each sum of sines of equal size has a standard deviation of 1.
        unit = math.sqrt(2.0 / _COMPONENTS)
        low = unit * np.sin(slow[:, None] * time + phases[0]).sum(axis=0)
        high = unit * np.sin(waves[:, None] * time + phases[1]).sum(axis=0)
        columns.append(full * (mean + size * (low + _WAVE_SHARE * high)))
    return np.column_stack(columns)


def by_decades(draw: np.random.Generator, ends: tuple[float, float], shape: tuple[int, ...]) -> FloatArray:
    """Return random numbers between ``ends`` whose logarithms are spread evenly."""
    return np.asarray(ends[0] * (ends[1] / ends[0]) ** draw.random(shape))


def is_saturated(vessel: Vessel, slack: FloatArray) -> bool:
    """Return whether limits kept the allocator from its demand, by its slack, shape (3,)."""
    return bool(np.any(np.abs(slack) > _MISSED * strength(vessel)))


def sequence(
    vessel: Vessel, start: Callable[[], Answer], steps: int, seed: int, share: float = SATURATED_SHARE
) -> DemandSequence:
    """Return a sequence in which about ``share`` of the steps are saturated.

    Parameters
    ----------
    vessel
        Gives size and time step of the demands.
    start
        Returns a method at its start, which answers one demand after another with its slack.
    steps, seed
        Length, and the number that everything random follows from.
    share
        Wanted share.
    """
    unit = demand_in_waves(vessel, steps, seed)
    dt = vessel.measurement.sample_time
    low, high = 0.0, _LARGEST_AMPLITUDE
    amplitude = found = 0.0
    for _ in range(_HALVINGS):
        amplitude = 0.5 * (low + high)
        answer = start()
        found = sum(is_saturated(vessel, answer(tau, dt)) for tau in amplitude * unit) / steps
        if found < share:
            low = amplitude
        else:
            high = amplitude
    return DemandSequence(amplitude * unit, dt, amplitude, found)


def starter(vessel: Vessel, settings: AllocatorSettings) -> Callable[[], Answer]:
    """Return what :func:`sequence` calls to start our allocator."""

    def start() -> Answer:
        allocator = Allocator(vessel, settings)
        return lambda tau, dt: allocator.step(tau, dt).slack

    return start


def record(vessel: Vessel, settings: AllocatorSettings, demands: FloatArray, dt: float) -> list[Step]:
    """Let the allocator answer ``demands``, shape (steps, 3), and keep every problem."""
    allocator = Allocator(vessel, settings)
    thrust = np.zeros(len(vessel.thrusters))
    azimuth = vessel.fixed_direction.copy()
    steps: list[Step] = []
    for tau in demands:
        result = allocator.step(tau, dt)
        problem = allocator.problem
        if problem is None:
            raise ValueError("record: every thruster is lost")
        steps.append(
            Step(tau, dt, thrust, azimuth, result.thrust.copy(), result.azimuth.copy(), result.slack.copy(), problem)
        )
        thrust, azimuth = steps[-1].thrust, steps[-1].azimuth
    return steps


def saturated_share(vessel: Vessel, steps: Sequence[Step]) -> float:
    """Return the share of ``steps`` that are saturated."""
    return sum(is_saturated(vessel, step.slack) for step in steps) / len(steps)
