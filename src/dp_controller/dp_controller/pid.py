"""Nonlinear PID motion controller, [Ruth] (B.15)-(B.18)."""

from __future__ import annotations

import math

from dp_controller.vectors import ZERO, Triple


class NonlinearPid:
    """tau_d = -K_D nu + K_P e + K_I int e dt with e = R(heading)^T (eta_d - eta), [Ruth] (B.15).

    The integral is of the error in the body frame, as printed, and is kept as a generalized force: so a change of K_I
    does not move it. Against wind-up, what the thrusters fell short of is fed back into it (back-calculation).

    Parameters
    ----------
    proportional, integral, derivative
        Diagonals of K_P, K_I and K_D, [Ruth] (B.17), (B.18), (B.16).

    Attributes
    ----------
    force
        Integral part, N, N, N m, body frame.
    """

    __slots__ = ("_derivative", "_integral", "_proportional", "force")

    def __init__(self, proportional: Triple, integral: Triple, derivative: Triple) -> None:
        self._proportional = proportional
        self._integral = integral
        self._derivative = derivative
        self.force: Triple = ZERO

    @property
    def gains(self) -> tuple[Triple, Triple, Triple]:
        """Diagonals of K_P, K_I and K_D."""
        return self._proportional, self._integral, self._derivative

    @gains.setter
    def gains(self, gains: tuple[Triple, Triple, Triple]) -> None:
        self._proportional, self._integral, self._derivative = gains

    def proportional(self, error: Triple) -> Triple:
        """Return K_P e for a body-frame error (m, m, rad)."""
        k = self._proportional
        return k[0] * error[0], k[1] * error[1], k[2] * error[2]

    def derivative(self, velocity: Triple, reference: Triple) -> Triple:
        """Return -K_D (nu - nu_d), both in the body frame of the vessel; (B.15) has nu_d = 0."""
        k = self._derivative
        return (
            -k[0] * (velocity[0] - reference[0]),
            -k[1] * (velocity[1] - reference[1]),
            -k[2] * (velocity[2] - reference[2]),
        )

    def integrate(self, error: Triple, shortfall: Triple, dt: float, anti_windup_time: float) -> None:
        """Advance the integral by one sample.

        Parameters
        ----------
        error
            Body frame; zero in an axis whose integral rests.
        shortfall
            Achieved minus demanded generalized force at the last sample; zero in an axis whose integral rests.
        dt
            Length of the sample, s.
        anti_windup_time
            Time constant (s) with which the integral gives way to the shortfall; 0 for no anti-windup.
        """
        k, force = self._integral, self.force
        # Exact for a shortfall that stays: no sample is too long for the time constant.
        share = -math.expm1(-dt / anti_windup_time) if anti_windup_time > 0.0 else 0.0
        self.force = (
            force[0] + k[0] * error[0] * dt + share * shortfall[0],
            force[1] + k[1] * error[1] * dt + share * shortfall[1],
            force[2] + k[2] * error[2] * dt + share * shortfall[2],
        )
