"""How heavily a propeller is loaded: tau, B_p, efficiency, and the diameter and pitch for a thrust at a speed.

[Ruth] (2.22)-(2.31). tau = sqrt(rho) D V_A / sqrt(T) is zero at bollard pull and infinite without thrust. At one pitch
ratio it fixes the advance number, and so everything else that has no dimension.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.conversion import efficiency
from marine_model.propellers.optimal import advance_number, optimal_pitch
from marine_model.propellers.zero_thrust import last_advance_number

_SEARCH_POINTS = 65  # pitch ratios; between the best one and its neighbours the search is continuous


def loading(diameter: ArrayLike, advance_speed: ArrayLike, thrust: ArrayLike, density: float) -> FloatArray:
    """Return tau, [Ruth] (2.26), from diameter (m), advance speed (m/s), thrust (N), density (kg/m^3).

    With the desired thrust it is tau_d of (2.31).

    Raises
    ------
    InputError
        If diameter, thrust or density is not above 0, or the advance speed is negative.
    """
    D, V, T = (
        _positive("diameter", diameter),
        _not_negative("advance_speed", advance_speed),
        _positive("thrust", thrust),
    )
    _positive("density", density)
    return np.asarray(math.sqrt(density) * D * V / np.sqrt(T))


def loading_from_coefficients(advance_number: ArrayLike, thrust_coefficient: ArrayLike) -> FloatArray:
    """Return tau = J / sqrt(K_T), [Ruth] (2.26); infinite where K_T is zero, NaN where it is negative."""
    J, K_T = np.asarray(advance_number, dtype=np.float64), np.asarray(thrust_coefficient, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(J / np.sqrt(K_T))


def desired_loading(loading: ArrayLike, thrust_sensitivity: ArrayLike) -> FloatArray:
    """Return tau_d = tau sqrt(st), with st = T / T_d.

    [Ruth] (2.31) starts with tau_d = sqrt(rho) D V_A / sqrt(T_d). As T_d = T / st, that is tau sqrt(st); the print
    puts st T for T_d and so arrives at tau / sqrt(st).
    """
    return np.asarray(
        np.asarray(loading, dtype=np.float64) * np.sqrt(_not_negative("thrust_sensitivity", thrust_sensitivity))
    )


def power_loading(advance_number: ArrayLike, torque_coefficient: ArrayLike) -> FloatArray:
    """Return B_p = 33.07 sqrt(K_Q) / J^(5/2), [Ruth] (2.27); infinite at J = 0.

    The other form, 60 n sqrt(P) / V_A^(5/2), gives the same number with V_A in knots, P in horsepower of 76 kgf m/s
    and fresh water, as in the B_p-delta diagrams, not in SI units.
    """
    J, K_Q = _not_negative("advance_number", advance_number), _positive("torque_coefficient", torque_coefficient)
    with np.errstate(divide="ignore"):
        return np.asarray(33.07 * np.sqrt(K_Q) / J**2.5)


def power_coefficient(thrust_coefficient: ArrayLike, torque_coefficient: ArrayLike) -> FloatArray:
    """Return 2 pi K_Q / K_T^(3/2), the power P sqrt(rho) D / T^(3/2) in the manner of [Ruth] (3.11)."""
    K_T = _positive("thrust_coefficient", thrust_coefficient)
    return np.asarray(2.0 * math.pi * np.asarray(torque_coefficient, dtype=np.float64) / K_T**1.5)


def diameter_for(loading: ArrayLike, advance_speed: ArrayLike, thrust: ArrayLike, density: float) -> FloatArray:
    """Return D = tau sqrt(T) / (V_A sqrt(rho)), m, [Ruth] (2.28). Raises InputError for what is not above 0."""
    tau, V, T = _positive("loading", loading), _positive("advance_speed", advance_speed), _positive("thrust", thrust)
    _positive("density", density)
    return np.asarray(tau * np.sqrt(T) / (V * math.sqrt(density)))


def propeller_demand(
    ship_speed: ArrayLike, resistance: ArrayLike, wake_fraction: ArrayLike, thrust_deduction: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return advance speed V_S (1 - w) in m/s and thrust R / (1 - t) in N, step 2 of [Ruth] 2.2.1.

    Raises
    ------
    InputError
        If speed or resistance is not above 0, or a fraction is not below 1.
    """
    V, R = _positive("ship_speed", ship_speed), _positive("resistance", resistance)
    w = _fraction("wake_fraction", wake_fraction)
    t = _fraction("thrust_deduction", thrust_deduction)
    return V * (1.0 - w), R / (1.0 - t)


def largest_loading(model: PropellerModel, pitch_ratio: ArrayLike | None = None) -> FloatArray:
    """Return the tau at which the data of a model end; infinite where thrust falls to zero within them.

    Arguments and errors as in :func:`last_advance_number`.
    """
    pitch = _pitch(model, pitch_ratio)
    J = last_advance_number(model, pitch)
    K_T = np.asarray(model.coefficients(J, pitch)[0])
    # What rounding leaves of a thrust that ends.
    return np.where(K_T > 1e-9, loading_from_coefficients(J, np.maximum(K_T, 0.0)), np.inf)


@dataclass(frozen=True)
class BestPoint:
    """Where a family of propellers is most efficient: peak of the plot of efficiency over (tau, P/D)."""

    loading: float
    pitch_ratio: float
    advance_number: float
    efficiency: float


def best_point(model: PropellerModel, pitch_range: tuple[float, float] | None = None) -> BestPoint:
    """Return the largest efficiency over advance number and pitch ratio, steps 3 and 4 of [Ruth] 2.2.1.

    Parameters
    ----------
    model
        The family of propellers.
    pitch_range
        Least and largest P/D to choose from; all that the model knows when None.

    Raises
    ------
    InputError
        If efficiency still rises where the model ends, so that there is no best point; or there is no thrust.
    """
    from scipy.optimize import minimize_scalar  # here: its import is slow

    low, high = pitch_range or model.pitch_range or (model.pitch_ratio, model.pitch_ratio)

    def peak(pitch: float) -> tuple[float, float]:
        end = float(last_advance_number(model, pitch))
        found = minimize_scalar(
            lambda J: -float(efficiency(J, *model.coefficients(J, pitch))),
            bounds=(0.0, end),
            method="bounded",
            options={"xatol": 1e-9},
        )
        if found.x > end - 1e-6:
            raise InputError(
                f"propeller: expected an efficiency that falls before the model ends, found it rising at J = {end:g}"
            )
        return -found.fun, float(found.x)

    pitches = np.linspace(low, high, _SEARCH_POINTS) if high > low else np.array([low])
    best = int(np.argmax([peak(pitch)[0] for pitch in pitches]))
    pitch = float(pitches[best])
    if 0 < best < len(pitches) - 1:
        between = (pitches[best - 1], pitches[best + 1])
        pitch = float(minimize_scalar(lambda p: -peak(p)[0], bounds=between, method="bounded").x)
    value, J = peak(pitch)
    tau = float(loading_from_coefficients(J, model.coefficients(J, pitch)[0]))
    return BestPoint(tau, pitch, J, value)


@dataclass(frozen=True)
class Selection:
    """Propellers for given thrusts at given speeds; arrays of one shape.

    Attributes
    ----------
    diameter
        D, m.
    loading, pitch_ratio, advance_number, efficiency
        tau, P/D, J, eta_0.
    shaft_speed
        n, Hz.
    power
        P = V_A T / eta_0, W.
    """

    diameter: FloatArray
    loading: FloatArray
    pitch_ratio: FloatArray
    advance_number: FloatArray
    efficiency: FloatArray
    shaft_speed: FloatArray
    power: FloatArray


def select(
    model: PropellerModel,
    advance_speed: ArrayLike,
    thrust: ArrayLike,
    density: float,
    largest_diameter: ArrayLike | None = None,
) -> Selection:
    """Return the most efficient diameter and pitch ratio, steps 3 to 5 of [Ruth] 2.2.1.

    Where the best diameter is larger than there is room for, the largest one is taken; that fixes tau as in (2.30),
    and the pitch ratio is the best one at that tau.

    Parameters
    ----------
    model
        The family of propellers; its own diameter does not matter.
    advance_speed, thrust
        V_A, m/s, and T, N, above 0; broadcast together.
    density
        kg/m^3.
    largest_diameter
        m, broadcast with the others; None where there is room for any.

    Raises
    ------
    InputError
        If a value is not above 0, or the family has no best point.
    """
    V, T = np.broadcast_arrays(_positive("advance_speed", advance_speed), _positive("thrust", thrust))
    best = best_point(model)
    D = diameter_for(best.loading, V, T, density)
    tau, pitch = np.full(D.shape, best.loading), np.full(D.shape, best.pitch_ratio)
    if largest_diameter is not None:
        D, largest = np.broadcast_arrays(D, _positive("largest_diameter", largest_diameter))
        V, T, tau, pitch = (np.broadcast_to(value, D.shape) for value in (V, T, tau, pitch))
        narrow = largest < D
        D = np.minimum(D, largest)
        tau = np.where(narrow, loading(D, V, T, density), tau)
        pitch = np.where(narrow, optimal_pitch(model, np.where(narrow, tau, best.loading)), pitch)
    J = advance_number(model, tau, pitch)
    eta = efficiency(J, *model.coefficients(J, pitch))
    return Selection(D, tau, pitch, J, eta, V / (J * D), V * T / eta)


def _pitch(model: PropellerModel, pitch_ratio: ArrayLike | None) -> FloatArray:
    return np.asarray(model.pitch_ratio if pitch_ratio is None else pitch_ratio, dtype=np.float64)


def _numbers(name: str, value: ArrayLike) -> FloatArray:
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers, found {value!r}") from error
    if not np.all(np.isfinite(numbers)):
        raise InputError(f"{name}: expected finite numbers, found {numbers[~np.isfinite(numbers)][0]}")
    return numbers


def _positive(name: str, value: ArrayLike) -> FloatArray:
    numbers = _numbers(name, value)
    if np.any(numbers <= 0.0):
        raise InputError(f"{name}: expected numbers above 0, found {numbers.min()}")
    return numbers


def _not_negative(name: str, value: ArrayLike) -> FloatArray:
    numbers = _numbers(name, value)
    if np.any(numbers < 0.0):
        raise InputError(f"{name}: expected numbers of at least 0, found {numbers.min()}")
    return numbers


def _fraction(name: str, value: ArrayLike) -> FloatArray:
    numbers = _numbers(name, value)
    if np.any(numbers >= 1.0):
        raise InputError(f"{name}: expected a fraction below 1, found {numbers.max()}")
    return numbers
