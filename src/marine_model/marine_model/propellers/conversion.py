"""From forces to coefficients and back, and between the two sets of coefficients: [Ruth] (2.9)-(2.19), (2.22)-(2.23).

All functions are vectorised by the rules of numpy broadcasting. n is in Hz, angles are in rad.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Tangential speed over n D at 0.7 R, [Ruth] (2.16).
ROTATION = 0.7 * np.pi


def advance_number(advance_speed: ArrayLike, shaft_speed: ArrayLike, diameter: ArrayLike) -> FloatArray:
    """Return J = V_A / (n D), [Ruth] (2.11). Raises InputError at n = 0 or D not above 0."""
    return _numbers(advance_speed) / (_turning(shaft_speed) * _positive("diameter", diameter))


def thrust_coefficient(
    thrust: ArrayLike, shaft_speed: ArrayLike, diameter: ArrayLike, density: ArrayLike
) -> FloatArray:
    """Return K_T = T / (rho D^4 n^2), [Ruth] (2.9). Raises InputError at n = 0, D or rho not above 0."""
    scale = _positive("density", density) * _positive("diameter", diameter) ** 4
    return _numbers(thrust) / (scale * _turning(shaft_speed) ** 2)


def torque_coefficient(
    torque: ArrayLike, shaft_speed: ArrayLike, diameter: ArrayLike, density: ArrayLike
) -> FloatArray:
    """Return K_Q = Q / (rho D^5 n^2), [Ruth] (2.10). Raises InputError at n = 0, D or rho not above 0."""
    scale = _positive("density", density) * _positive("diameter", diameter) ** 5
    return _numbers(torque) / (scale * _turning(shaft_speed) ** 2)


def advance_angle(advance_speed: ArrayLike, shaft_speed: ArrayLike, diameter: ArrayLike) -> FloatArray:
    """Return beta, [Ruth] (2.12) in the quadrants of Table 2.1: -pi to pi; 0 where both speeds are 0."""
    rotation = ROTATION * _numbers(shaft_speed) * _positive("diameter", diameter)
    return np.asarray(np.arctan2(_numbers(advance_speed), rotation))


def inflow_speed(advance_speed: ArrayLike, shaft_speed: ArrayLike, diameter: ArrayLike) -> FloatArray:
    """Return V_inf at 0.7 R, m/s, [Ruth] (2.16)."""
    rotation = ROTATION * _numbers(shaft_speed) * _positive("diameter", diameter)
    return np.asarray(np.hypot(_numbers(advance_speed), rotation))


def four_quadrant_scale(
    shaft_speed: ArrayLike, advance_speed: ArrayLike, diameter: ArrayLike, density: ArrayLike
) -> FloatArray:
    """Return rho A_0 V_inf^2 / 2, N: T = C_T times it, Q = C_Q D times it, [Ruth] (2.13)-(2.15)."""
    D = _positive("diameter", diameter)
    square = _numbers(advance_speed) ** 2 + (ROTATION * _numbers(shaft_speed) * D) ** 2
    return np.asarray(0.125 * np.pi * _positive("density", density) * D**2 * square)


def advance_angle_of(advance_number: ArrayLike) -> FloatArray:
    """Return beta of J for n > 0, [Ruth] (2.19): -pi/2 to pi/2."""
    return np.asarray(np.arctan(_numbers(advance_number) / ROTATION))


def advance_number_of(advance_angle: ArrayLike) -> FloatArray:
    """Return J of beta, the inverse of (2.19), for n > 0. Raises InputError if beta is not within 90 deg."""
    angle = _numbers(advance_angle)
    if (np.abs(angle) >= 0.5 * np.pi).any():
        outside = angle[np.abs(angle) >= 0.5 * np.pi].flat[0]
        raise InputError(f"advance_angle: expected a number within pi/2 of 0, found {outside:g}")
    return np.asarray(ROTATION * np.tan(angle))


def open_water_coefficients(four_quadrant: ArrayLike, advance_number: ArrayLike) -> FloatArray:
    """Return K_T of C_T, or K_Q of C_Q, [Ruth] (2.17)-(2.18)."""
    return _numbers(four_quadrant) * _ratio(advance_number)


def four_quadrant_coefficients(open_water: ArrayLike, advance_number: ArrayLike) -> FloatArray:
    """Return C_T of K_T, or C_Q of K_Q, the inverse of (2.17)-(2.18)."""
    return _numbers(open_water) / _ratio(advance_number)


def power(shaft_speed: ArrayLike, torque: ArrayLike) -> FloatArray:
    """Return P = 2 pi n Q, W, [Ruth] (2.22)."""
    return np.asarray(2.0 * np.pi * _numbers(shaft_speed) * _numbers(torque))


def efficiency(advance_number: ArrayLike, thrust_coefficient: ArrayLike, torque_coefficient: ArrayLike) -> FloatArray:
    """Return eta_0 = V_A T / (2 pi n Q) = J K_T / (2 pi K_Q), [Ruth] (2.23). Raises InputError at K_Q = 0."""
    torque = _numbers(torque_coefficient)
    if (torque == 0.0).any():
        raise InputError("torque_coefficient: expected no 0 for an efficiency, found 0")
    return np.asarray(_numbers(advance_number) * _numbers(thrust_coefficient) / (2.0 * np.pi * torque))


def _ratio(advance_number: ArrayLike) -> FloatArray:
    """Return K over C: pi/8 (J^2 + (0.7 pi)^2)."""
    return np.asarray(0.125 * np.pi * (_numbers(advance_number) ** 2 + ROTATION**2))


def _numbers(value: ArrayLike) -> FloatArray:
    return np.asarray(value, dtype=np.float64)


def _turning(shaft_speed: ArrayLike) -> FloatArray:
    speed = _numbers(shaft_speed)
    if (speed == 0.0).any():
        raise InputError("shaft_speed: expected no 0 for a coefficient, found 0")
    return speed


def _positive(name: str, value: ArrayLike) -> FloatArray:
    number = _numbers(value)
    if not (number > 0.0).all():
        raise InputError(f"{name}: expected numbers above 0, found {number[~(number > 0.0)].flat[0]:g}")
    return number
