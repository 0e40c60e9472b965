"""What is wrong with the answers of a method: failures, limits broken, force missed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import asin, pi

import numpy as np

from benchmarks.demands import Step
from benchmarks.peers.peer import Commands
from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import generalized_force

# N and rad: what counts as a limit broken. A thousandth of the smallest thrust limit of CyberShip III, and less than
# azimuth drives resolve; the largest excess is told whatever its size.
TOLERANCE = 5e-4


@dataclass(slots=True)
class Excess:
    """By how much a limit was broken, and how often: once a step at most."""

    largest: float = 0.0
    count: int = 0

    def note(self, excess: float) -> None:
        """Take the excess of one step."""
        self.largest = max(self.largest, excess)
        self.count += excess > TOLERANCE

    def __str__(self) -> str:
        return f"{self.count} (largest {self.largest:.2g})"


@dataclass(slots=True)
class Verdict:
    """Counts over the steps that one method was given.

    Attributes
    ----------
    steps, failures
        All steps; those without an answer, because the library raised or said that it failed.
    thrust, thrust_rate, azimuth_rate
        Excess over the limits: N, N/s times the time step, rad/s times the time step.
    force_errors
        Largest component (N, N m) of the difference to the force of the optimum, one an answer.
    bad_steps
        Steps that failed or broke a limit.
    """

    steps: int = 0
    failures: int = 0
    thrust: Excess = field(default_factory=Excess)
    thrust_rate: Excess = field(default_factory=Excess)
    azimuth_rate: Excess = field(default_factory=Excess)
    force_errors: list[float] = field(default_factory=list)
    bad_steps: int = 0

    def __str__(self) -> str:
        if not self.force_errors:
            return f"{self.failures} of {self.steps} failed"
        return (
            f"{self.failures} of {self.steps} failed; limits broken: thrust {self.thrust} N, thrust rate "
            f"{self.thrust_rate} N, azimuth rate {self.azimuth_rate} rad a step; force off the optimum by "
            f"{float(np.median(self.force_errors)):.2g} in the median, {max(self.force_errors):.2g} at most (N, N m)"
        )


def judge(
    vessel: Vessel,
    steps: Sequence[Step],
    optimum: Sequence[FloatArray],
    places: Sequence[int],
    answers: Sequence[Commands | None],
    own_course: bool = False,
) -> Verdict:
    """Return the verdict on ``answers`` to the steps at ``places``.

    The program widens the azimuth window of a rotating thruster by c_2 (T_max - T_min) newtons ((4.38)-(4.39)), so that
    the thruster may turn without thrust. A direction within that is not counted.

    Parameters
    ----------
    vessel
        Limits and geometry.
    steps
        All steps.
    optimum
        Generalized force of the optimum of every step, shape (3,) each.
    places, answers
        Which steps were answered, and how; None for a failure.
    own_course
        Rates are counted from the method's own last answer instead of from the step's: for methods that do not know
        where the thrusters are.
    """
    verdict = Verdict()
    last: tuple[int, Commands] | None = None
    width = vessel.allocator.zero_region * (vessel.thrust_max - vessel.thrust_min)
    for place, answer in zip(places, answers, strict=True):
        step = steps[place]
        verdict.steps += 1
        if answer is None:
            verdict.failures += 1
            verdict.bad_steps += 1
            last = None
            continue
        thrust, azimuth = answer
        before: Commands | None = (step.thrust_before, step.azimuth_before)
        if own_course:
            before = last[1] if last is not None and last[0] == place - 1 else None
        last = place, answer
        excesses = [float(np.max(np.maximum(thrust - vessel.thrust_max, vessel.thrust_min - thrust)))]
        verdict.thrust.note(excesses[0])
        if before is not None:
            excesses.append(float(np.max(np.abs(thrust - before[0]) - vessel.thrust_rate * step.dt)))
            verdict.thrust_rate.note(excesses[1])
            turns = [
                abs(wrap_angle(float(now - then))) - (asin(small / abs(force)) if abs(force) > small else pi)
                for now, then, force, small in zip(azimuth, before[1], thrust, width, strict=True)
            ]
            excesses.append(float(np.max(np.array(turns) - vessel.azimuth_rate * step.dt)))
            verdict.azimuth_rate.note(excesses[2])
        verdict.bad_steps += max(excesses) > TOLERANCE
        force = generalized_force(vessel.lever_x, vessel.lever_y, thrust, azimuth)
        verdict.force_errors.append(float(np.abs(force - optimum[place]).max()))
    return verdict
