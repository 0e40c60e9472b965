"""The observer's equations as a linear system at a given heading, [Ruth] B.3.1 after Fossen (2002).

    xi_dot  = A_w xi + K_1 y~           y~ = y - eta - C_w xi
    eta_dot = R(psi) nu + K_2 y~
    b_dot   = -T^-1 b + K_3 y~
    M nu_dot = -D nu + R(psi)^T b + tau + R(psi)^T K_4 y~

A_w is (B.8) with -omega_0^2 for its printed +omega_0^2: the wave model is an oscillator, s^2 + 2 lambda omega_0 s +
omega_0^2, and the plus sign would give it an unstable pole. With (B.9) the first part of xi is the wave-frequency
position and the second its integral; K_1 (B.11) is in that order, and gives the notch

    y~ / y = (s^2 + 2 lambda omega_0 s + omega_0^2) / (s^2 + 2 zeta_n omega_0 s + omega_0^2)  s / (s + omega_c)

when nu is not fed back.
"""

from __future__ import annotations

import math

import numpy as np

from dp_observer.exponential import LinearFlow, growth_rate
from marine_model.errors import InputError
from marine_model.frames import rotation
from marine_model.gains import ObserverGains
from marine_model.guards import FloatArray

# State vector, shape (15,). Two parts are scaled so that all numbers of the system matrix have a like size.
WAVE = slice(0, 3)  # wave-frequency position (m, m, rad) in map_ned
WAVE_INTEGRAL = slice(3, 6)  # its integral times omega_0 (m, m, rad)
POSITION = slice(6, 9)  # low-frequency position (m, m, rad) in map_ned
BIAS = slice(9, 12)  # bias in map_ned over the diagonal of M (m/s^2, m/s^2, rad/s^2)
VELOCITY = slice(12, 15)  # low-frequency velocity (m/s, m/s, rad/s) in the body frame
ORDER = 15
HEADING = 8  # index of the low-frequency heading
YAW_RATE = 14

# Headings at which stability is checked. R enters through its double angle only, so half a turn covers all.
_CHECKED_HEADINGS = np.linspace(0.0, math.pi, 36, endpoint=False)
_MARGIN = 1.05  # on the growth rate, for the headings between them


class ObserverModel:
    """System matrices of the observer for one vessel; ``set_heading`` and ``set_share`` make them current.

    Attributes
    ----------
    prediction
        F, shape (15, 15), of x_dot = F x + G tau: the observer without measurements. Read only after ``set_heading``.
    injection
        K, shape (15, 3), of y~.
    correction
        F - K C, shape (15, 15), with C x = eta + C_w xi: the observer with measurements; also the matrix of its error.
    force_input
        G, shape (15, 3).
    bias_scale
        Diagonal of M, shape (3,): bias (N, N, N m) per unit of its state.
    prediction_flow, correction_flow
        What carries a state through time with ``prediction`` and with ``correction``.

    Raises
    ------
    InputError
        If the gains do not give a stable observer.
    """

    def __init__(self, gains: ObserverGains) -> None:
        mass, damping = np.array(gains.mass), np.array(gains.damping)
        lam, omega = np.array(gains.wave_damping), np.array(gains.wave_frequency)
        cutoff = np.array(gains.cutoff_ratio) * omega  # omega_c
        notch = 2.0 * (np.array(gains.notch_damping) - lam)
        self._inverse_mass = np.linalg.inv(mass)
        self._velocity_gain = np.array(gains.velocity_gain)
        self._share = 1.0
        self.bias_scale = np.diag(mass).copy()

        self.injection = np.zeros((ORDER, 3))
        self.injection[WAVE] = np.diag(notch * omega)  # (B.11), first part
        self.injection[WAVE_INTEGRAL] = np.diag(-notch * cutoff)  # (B.11), second part, times omega_0
        self.injection[POSITION] = np.diag(cutoff)  # (B.12)
        self._bias_injection = np.diag(np.array(gains.bias_gain) / self.bias_scale)
        self.injection[BIAS] = self._bias_injection

        self.force_input = np.zeros((ORDER, 3))
        self.force_input[VELOCITY] = self._inverse_mass

        self.prediction = np.zeros((ORDER, ORDER))
        self.prediction[WAVE, WAVE] = np.diag(-2.0 * lam * omega)
        self.prediction[WAVE, WAVE_INTEGRAL] = np.diag(-omega)
        self.prediction[WAVE_INTEGRAL, WAVE] = np.diag(omega)
        self.prediction[BIAS, BIAS] = np.diag(-1.0 / np.array(gains.bias_time_constant))
        self.prediction[VELOCITY, VELOCITY] = -self._inverse_mass @ damping

        self.correction = self.prediction.copy()
        self.correction[:, WAVE] -= self.injection
        self.correction[:, POSITION] -= self.injection

        predictions, corrections = self._at_all_headings()
        _require_stable(corrections)
        self.prediction_flow = LinearFlow(ORDER, _MARGIN * growth_rate(predictions))
        self.set_share(0.0)
        without = self._at_all_headings()[1]
        self.set_share(1.0)
        self.correction_flow = LinearFlow(ORDER, _MARGIN * max(growth_rate(corrections), growth_rate(without)))

    def set_heading(self, heading: float) -> None:
        """Make the matrices those of ``heading`` (rad)."""
        rotated = rotation(heading)
        from_map = np.dot(self._inverse_mass, rotated.T)  # M^-1 R^T
        bias = from_map * self.bias_scale
        gain = from_map * self._velocity_gain
        if self._share != 1.0:
            gain *= self._share
        self.prediction[POSITION, VELOCITY] = rotated
        self.prediction[VELOCITY, BIAS] = bias
        self.injection[VELOCITY] = gain
        self.correction[POSITION, VELOCITY] = rotated
        self.correction[VELOCITY, BIAS] = bias
        np.negative(gain, out=gain)
        self.correction[VELOCITY, WAVE] = gain
        self.correction[VELOCITY, POSITION] = gain

    def set_share(self, share: float) -> None:
        """Make K_3 and K_4 ``share`` of their full values, from the next ``set_heading`` on."""
        if share == self._share:
            return
        self._share = share
        bias = self._bias_injection * share
        self.injection[BIAS] = bias
        self.correction[BIAS, WAVE] = -bias
        self.correction[BIAS, POSITION] = -bias

    def _at_all_headings(self) -> tuple[FloatArray, FloatArray]:
        """Return ``prediction`` and ``correction`` at the checked headings, shape (k, 15, 15) each."""
        predictions, corrections = [], []
        for heading in _CHECKED_HEADINGS:
            self.set_heading(float(heading))
            predictions.append(self.prediction.copy())
            corrections.append(self.correction.copy())
        return np.stack(predictions), np.stack(corrections)


def _require_stable(errors: FloatArray) -> None:
    growth = np.linalg.eigvals(errors).real.max(axis=1)
    worst = int(growth.argmax())
    if not growth[worst] < 0.0:
        raise InputError(
            "observer gains of the vessel: expected every eigenvalue of the error to have a negative real part, "
            f"found {growth[worst]:.4g} 1/s at heading {_CHECKED_HEADINGS[worst]:.3f} rad"
        )
