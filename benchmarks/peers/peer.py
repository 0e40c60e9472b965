"""What every peer of the allocator offers to be timed and judged."""

from __future__ import annotations

from abc import ABC, abstractmethod
from importlib.metadata import PackageNotFoundError, version
from math import atan2, hypot, pi
from typing import Any

import numpy as np

from benchmarks.demands import Step
from marine_model.errors import DpError
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray

Commands = tuple[FloatArray, FloatArray]

# Share of the largest thrust below which a direction says nothing, and the present one is kept.
_IDLE_SHARE = 1e-6


class PeerMissingError(DpError):
    """A peer cannot be imported; the message says why."""


class Peer(ABC):
    """One other way to answer a :class:`Step`.

    Only :meth:`solve` is timed. What a user could prepare elsewhere, and reading the answer, favours the peer.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Stable name, snake case."""

    @property
    @abstractmethod
    def title(self) -> str:
        """What it is, with its version and accuracy, as printed."""

    @property
    def remark(self) -> str:
        """What it cannot do by design; empty if nothing."""
        return ""

    @abstractmethod
    def prepare(self, step: Step) -> Any:
        """Return the task of ``step`` in the form that :meth:`solve` takes; not timed."""

    @abstractmethod
    def solve(self, task: Any) -> Any:
        """Solve; timed. May raise what the library raises."""

    @abstractmethod
    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return thrust (N) and direction (rad), shape (n,) each; None if the library says that it failed."""


def polar_form(step: Step, z: FloatArray) -> Commands:
    """Return thrust (N) and direction (rad) of the variables ``z``, shape (m,), of ``step.problem``.

    A force that points away from where the thruster points by more than 90 deg is taken as reverse thrust, which turns
    less. Nothing is brought into its limits: what breaks them shows.
    """
    problem = step.problem
    thrust, azimuth = np.zeros(len(step.thrust)), step.azimuth.copy()
    for i, j in enumerate(problem.fixed):
        thrust[j] = z[i]
    at = len(problem.fixed)
    idle = _IDLE_SHARE * max(1.0, float(np.abs(z).max()))
    for j in problem.rotating:
        size = hypot(z[at], z[at + 1])
        before = float(step.azimuth_before[j])
        turn = wrap_angle(atan2(z[at + 1], z[at]) - before) if size > idle else 0.0
        if abs(turn) > 0.5 * pi:
            turn, size = wrap_angle(turn + pi), -size
        thrust[j], azimuth[j] = size, wrap_angle(before + turn)
        at += 2
    return thrust, azimuth


def titled(distribution: str) -> str:
    """Return the name of ``distribution`` and its version, if it tells one."""
    try:
        return f"{distribution} {version(distribution)}"
    except PackageNotFoundError:
        return distribution
