"""A method that says what every thruster is to give, with no program to solve."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import Limit


class Wanted(NamedTuple):
    """What a method wants in one step.

    Attributes
    ----------
    thrust
        Of every thruster along its direction in this step, shape (n,), N. What exceeds the windows of the step is cut.
    tau_feasible
        What it reduced the demand to, over the degrees of freedom, shape (m,).
    load
        The demand over the edge of the method's own region in its direction: the demand is reduced above 1. NaN where
        it has no such region.
    detail
        What was reduced and why; empty if nothing.
    """

    thrust: FloatArray
    tau_feasible: FloatArray
    load: float
    detail: str


class MethodReport(NamedTuple):
    """How a method dealt with one demand, beside its commands.

    Attributes
    ----------
    tau_feasible, load, detail
        As in :class:`Wanted`.
    tau_qp
        What the quadratic program achieves for the same demand from the same operating point, shape (m,); NaN if it
        was not asked, or failed.
    """

    tau_feasible: FloatArray
    load: float
    detail: str
    tau_qp: FloatArray


class Method(ABC):
    """One of them, for one vessel under one set of settings."""

    def aim(self, limits: FloatArray, azimuth: FloatArray, tau: FloatArray) -> None:
        """Write into ``limits`` (n, 14) where azimuth thrusters are to turn; they stay at their fixed directions here.

        Parameters
        ----------
        limits
            Table of limits of this step, with no thruster that rotates.
        azimuth
            Commanded directions of the step before, shape (n,), rad.
        tau
            Demand, shape (m,).
        """
        return

    @abstractmethod
    def want(self, plans: FloatArray, limits: FloatArray, tau: FloatArray) -> Wanted:
        """Return thrusts for ``tau`` (m,) with every thruster pointing as in ``plans`` (n, 6)."""

    def measure_speed(self, speed: float) -> None:
        """Take the speed ahead through the water, m/s."""
        return


def thrust_range(limits: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the largest thrust of this step without rates, shape (n,), N; both 0 for a lost thruster."""
    enabled = limits[:, Limit.ENABLED]
    # A vessel file may leave out one way, and no range may leave out 0.
    lower: FloatArray = np.minimum(enabled * limits[:, Limit.THRUST_MIN], 0.0)
    upper: FloatArray = np.maximum(enabled * limits[:, Limit.THRUST_MAX] * limits[:, Limit.FACTOR], 0.0)
    return lower, upper


def both_ways(limits: FloatArray) -> FloatArray:
    """Return f^max, shape (n,), N: what every thruster gives ahead and astern alike."""
    lower, upper = thrust_range(limits)
    least: FloatArray = np.minimum(-lower, upper)
    return least
