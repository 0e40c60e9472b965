"""Azimuth motor of one thruster: a rate servo with a first-order lag and a rate limit, solved in closed form."""

from __future__ import annotations

import math

from marine_model.thruster import AzimuthThruster
from marine_model.vessel import Vessel


class AzimuthServo:
    """w_dot = (clamp(w_d) - w) / T, alpha_dot = w, exact for a demand w_d held over the step.

    Parameters
    ----------
    rate_max
        Limit of the demand, and so of the rate, rad/s.
    time_constant
        T, s.
    """

    __slots__ = ("_decay", "_dt", "_rate_max", "_time_constant", "_travel")

    def __init__(self, rate_max: float, time_constant: float) -> None:
        self._rate_max = rate_max
        self._time_constant = time_constant
        self._dt = 0.0
        self._decay = 1.0
        self._travel = 0.0

    def advance(self, angle: float, rate: float, demand: float, dt: float) -> tuple[float, float]:
        """Return angle (rad, not wrapped) and rate (rad/s) after ``dt`` (s) under ``demand`` (rad/s)."""
        if dt != self._dt:  # exponentials of the one step length in use
            self._dt = dt
            self._decay = math.exp(-dt / self._time_constant)
            self._travel = -math.expm1(-dt / self._time_constant) * self._time_constant
        limit = self._rate_max
        demand = -limit if demand < -limit else limit if demand > limit else demand
        excess = rate - demand
        return angle + demand * dt + excess * self._travel, demand + excess * self._decay


def azimuth_servos(vessel: Vessel) -> list[AzimuthServo | None]:
    """Return the servo of every thruster of ``vessel`` in file order; None for one that does not turn."""
    return [
        AzimuthServo(t.azimuth_drive.rate_max, t.azimuth_drive.time_constant)
        if isinstance(t, AzimuthThruster)
        else None
        for t in vessel.thrusters
    ]
