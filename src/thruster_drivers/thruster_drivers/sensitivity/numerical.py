"""Sensitivity functions from the equilibrium of control law and propeller, found by root finding.

The control laws are those of [Ruth] (3.8)-(3.24) in newtons, newton metres and hertz; nothing of the closed forms is
used. PID terms are at rest: what they control has reached its reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from marine_model.errors import InputError
from marine_model.guards import finite_number, positive_number
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.zero_thrust import last_advance_number
from thruster_drivers.sensitivity.sensitivity import NominalCoefficients, Sensitivity, nominal_coefficients

# Relative accuracy of a root: the least that brentq takes, 4 eps.
_ACCURACY = 4.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Operation:
    """What a thruster is asked for, and where.

    Attributes
    ----------
    thrust
        Desired thrust T_d, N, above 0.
    advance_speed
        V_A, m/s, at least 0.
    density
        kg/m^3.

    Raises
    ------
    InputError
        If one of them is out of range.
    """

    thrust: float
    advance_speed: float
    density: float

    def __post_init__(self) -> None:
        positive_number("thrust", self.thrust)
        positive_number("density", self.density)
        if finite_number("advance_speed", self.advance_speed) < 0.0:
            raise InputError(f"advance_speed: expected at least 0, found {self.advance_speed}")


@dataclass(frozen=True)
class TorqueWeight:
    """alpha(n) = exp(-k |p n|^r) of combined control, [Ruth] (3.14)."""

    gain: float  # k
    time: float  # p, s
    exponent: float  # r

    def __call__(self, shaft_speed: float) -> float:
        """Return alpha at n, Hz."""
        return math.exp(-self.gain * abs(self.time * shaft_speed) ** self.exponent)


class Equilibrium:
    """Where each controller comes to rest on one propeller.

    Parameters
    ----------
    model
        The propeller, with its diameter.
    pitch_ratio
        P/D where the controller does not move it; None for the design pitch ratio.
    nominal
        K_Tc and K_Qc; None for those of the model at J = 0 and that pitch ratio.
    """

    def __init__(
        self,
        model: PropellerModel,
        pitch_ratio: float | None = None,
        nominal: NominalCoefficients | None = None,
    ) -> None:
        self._model = model
        self._pitch_ratio = model.pitch_ratio if pitch_ratio is None else pitch_ratio
        self._nominal = nominal_coefficients(model, self._pitch_ratio) if nominal is None else nominal

    def shaft_speed(self, operation: Operation) -> Sensitivity:
        """Return the sensitivities of shaft-speed control, [Ruth] (3.8)-(3.9)."""
        return self._at(operation, self._desired_speed(operation), self._pitch_ratio)

    def torque(self, operation: Operation) -> Sensitivity:
        """Return the sensitivities of torque control, [Ruth] (3.10)."""
        desired = self._desired_torque(operation)
        return self._balance(operation, lambda n: desired)

    def power(self, operation: Operation) -> Sensitivity:
        """Return the sensitivities of power control, [Ruth] (3.11)-(3.12)."""
        desired = self._desired_power(operation)
        return self._balance(operation, lambda n: desired / (2.0 * math.pi * n))

    def combined(self, operation: Operation, weight: TorqueWeight) -> Sensitivity:
        """Return the sensitivities of combined control, [Ruth] (3.13)-(3.14)."""
        torque, power = self._desired_torque(operation), self._desired_power(operation)

        def law(n: float) -> float:
            alpha = weight(n)
            return alpha * torque + (1.0 - alpha) * power / (2.0 * math.pi * n)

        return self._balance(operation, law)

    def pitch(self, operation: Operation, shaft_speed: float) -> Sensitivity:
        """Return the sensitivities of pitch control at a constant ``shaft_speed`` (Hz), [Ruth] (3.15)-(3.16).

        P_d and Q_d are those of (3.27): at the commanded pitch ratio and J = 0.

        Raises
        ------
        InputError
            If no pitch ratio in range gives the desired thrust at that speed and J = 0.
        """
        n = positive_number("shaft_speed", shaft_speed)
        scale = operation.density * self._model.diameter**4 * n**2
        wanted = operation.thrust / scale
        ratio = self._ratio(
            lambda p: float(self._model.coefficients(0.0, p)[0]) - wanted, wanted, f"K_Td = {wanted:.4g}"
        )
        K_Q = float(self._model.coefficients(0.0, ratio)[1])
        return self._result(operation, n, ratio, n, K_Q * scale * self._model.diameter)

    def torque_shaft_speed(self, operation: Operation) -> Sensitivity:
        """Return the sensitivities of torque/shaft-speed control, [Ruth] (3.22)-(3.24).

        P_d is that of power control, (3.11).

        Raises
        ------
        InputError
            If no pitch ratio in range takes the desired torque at the desired speed.
        """
        P_d, K_Qc = self._desired_power(operation), self._nominal.torque
        scale = operation.density * self._model.diameter**5
        Q_d = float((K_Qc * scale / (2.0 * math.pi) ** 2 * P_d**2) ** (1.0 / 3.0))
        n = (P_d / (2.0 * math.pi * K_Qc * scale)) ** (1.0 / 3.0)

        def excess(ratio: float) -> float:
            # On the way to the root a low pitch may be past its data: the forces go on there.
            _, torque = self._model.forces(n, operation.advance_speed, operation.density, ratio)
            return float(torque) - Q_d

        ratio = self._ratio(excess, Q_d, f"Q_d = {Q_d:.4g} N m")
        return self._result(operation, n, ratio, n, Q_d)

    def _desired_speed(self, operation: Operation) -> float:
        return math.sqrt(operation.thrust / (self._nominal.thrust * operation.density * self._model.diameter**4))

    def _desired_torque(self, operation: Operation) -> float:
        return self._nominal.torque * self._model.diameter / self._nominal.thrust * operation.thrust

    def _desired_power(self, operation: Operation) -> float:
        K_Tc, K_Qc = self._nominal
        factor = 2.0 * math.pi * K_Qc / (math.sqrt(operation.density) * self._model.diameter * K_Tc**1.5)
        return float(factor * operation.thrust**1.5)

    def _load(self, operation: Operation, n: float, ratio: float) -> tuple[float, float]:
        """Return thrust, N, and torque, N m. Raises InputError outside the range of the model."""
        D = self._model.diameter
        K_T, K_Q = self._model.coefficients(operation.advance_speed / (n * D), ratio)
        scale = operation.density * D**4 * n**2
        return float(K_T) * scale, float(K_Q) * scale * D

    def _balance(self, operation: Operation, law: Callable[[float], float]) -> Sensitivity:
        """Return the equilibrium of motor torque ``law(n)`` and propeller torque at a held pitch."""

        def surplus(n: float) -> float:
            return self._load(operation, n, self._pitch_ratio)[1] - law(n)

        # From the speed at which the propeller loses its thrust; in bollard pull from far below what is desired.
        desired = self._desired_speed(operation)
        low = 1e-3 * desired
        if operation.advance_speed > 0.0:
            end = float(last_advance_number(self._model, self._pitch_ratio))
            if end == 0.0:
                raise InputError("advance_speed: expected 0 for a propeller known at zero advance alone")
            low = max(low, operation.advance_speed / (self._model.diameter * end))
        if surplus(low) > 0.0:
            raise InputError(
                f"advance_speed: no equilibrium in the range of the propeller at {operation.advance_speed} m/s"
            )
        high = max(low, desired)
        while surplus(high) < 0.0:
            high *= 2.0
        n = brentq(surplus, low, high, xtol=1e-300, rtol=_ACCURACY)
        return self._at(operation, n, self._pitch_ratio)

    def _ratio(self, excess: Callable[[float], float], wanted: float, words: str) -> float:
        """Return the pitch ratio in range where ``excess`` over ``wanted`` is zero. Raises InputError."""
        if self._model.pitch_range is None:
            raise InputError("propeller: expected one of controllable pitch, found a fixed pitch")
        low, high = self._model.pitch_range
        at_low, at_high = excess(low), excess(high)
        # What a limit itself gives may be off by rounding.
        for end, value in ((low, at_low), (high, at_high)):
            if abs(value) <= 1e-12 * wanted:
                return end
        if at_low * at_high > 0.0:
            raise InputError(f"pitch_ratio: no value from {low} to {high} gives {words}")
        return float(brentq(excess, low, high, xtol=1e-300, rtol=_ACCURACY))

    def _at(self, operation: Operation, n: float, ratio: float) -> Sensitivity:
        return self._result(operation, n, ratio, self._desired_speed(operation), self._desired_torque(operation))

    def _result(self, operation: Operation, n: float, ratio: float, n_d: float, Q_d: float) -> Sensitivity:
        T, Q = self._load(operation, n, ratio)
        D, V = self._model.diameter, operation.advance_speed
        values = (
            V / (n * D),
            ratio,
            math.sqrt(operation.density) * D * V / math.sqrt(operation.thrust),
            n / n_d,
            T / operation.thrust,
            Q / Q_d,
            n * Q / (n_d * Q_d),
        )
        return Sensitivity(*(np.asarray(value, dtype=np.float64) for value in values))
