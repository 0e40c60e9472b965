"""Which pitch ratio gives a thrust for the least power: the maps of the consolidated controllers, [Ruth] 3.4.

At a given tau = J / sqrt(K_T) = sqrt(rho) D V_A / sqrt(T), [Ruth] (2.26), thrust T costs the power

    P = 2 pi n Q = 2 pi T^(3/2) / (sqrt(rho) D) K_Q / K_T^(3/2),

so the best pitch ratio is where K_Q / K_T^(3/2) is least. Away from tau = 0 that is where the efficiency (2.23),
eta = tau / (2 pi) K_T^(3/2) / K_Q, is greatest; at tau = 0 every efficiency is zero, and the criterion still holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel

# The longest tau that the maps hold: beyond it the thrust is below a hundredth of rho D^2 V_A^2.
TAU_MAX = 10.0

_TAU_POINTS = 401
_PITCH_POINTS = 46
# Halvings of a bracket of order 1: to rounding, and to 1e-9, where only the place of an optimum is looked for.
_HALVINGS, _HALVINGS_OF_A_SEARCH = 52, 30
# The advance number of no thrust has an infinite tau; this share of it is as good.
_END = 1.0 - 1e-9
# No screw gives thrust at this advance number; where a four-quadrant model, which knows all of them, is looked at.
_FAR = 16.0
# Pitch ratios that give less of the largest K_T at J = 0 are for little thrust, not for the best of it.
_LEAST_THRUST = 0.05


class OptimalMaps:
    """The best pitch ratio of a propeller over tau and what belongs to it, [Ruth] (3.17)-(3.20) and Figure 3.7.

    All maps are vectorised. Below tau = 0 and above ``TAU_MAX`` they hold the value of that end. Where one local
    optimum takes over from another the best pitch ratio jumps; the maps cross such a jump within one step of tau of
    0.025.

    Parameters
    ----------
    model
        A propeller model with a range of pitch ratios.
    pitch_range
        Least and largest pitch ratio of the actuator, within the model's; the model's when None.

    Raises
    ------
    InputError
        If the model knows one pitch, or the range is empty or reaches beyond the model's.
    """

    def __init__(self, model: PropellerModel, pitch_range: tuple[float, float] | None = None) -> None:
        from scipy.interpolate import PchipInterpolator  # here: its import is slow

        self.pitch_range = _pitch_range(model, pitch_range)
        tau = TAU_MAX * np.linspace(0.0, 1.0, _TAU_POINTS)
        best = optimal_pitch(model, tau, self.pitch_range)
        K_T, K_Q = model.coefficients(advance_number(model, tau, best), best)
        # Monotone pieces: the pitch ratio has a kink where it reaches the end of its range.
        self._pitch_ratio = PchipInterpolator(tau, best)
        self._torque_coefficient = PchipInterpolator(tau, K_Q)
        self._torque_per_thrust = PchipInterpolator(tau, K_Q / K_T)
        self._speed = PchipInterpolator(tau, 1.0 / np.sqrt(K_T))

    def pitch_ratio(self, tau: ArrayLike) -> FloatArray:
        """Return k(tau), [Ruth] (3.18): the best pitch ratio."""
        return np.asarray(self._pitch_ratio(_held(tau)))

    def torque_per_thrust(self, tau: ArrayLike) -> FloatArray:
        """Return h(tau) = K_Q / K_T at the best pitch ratio, [Ruth] (3.17): torque is h D T."""
        return np.asarray(self._torque_per_thrust(_held(tau)))

    def speed(self, tau: ArrayLike) -> FloatArray:
        """Return m(tau) = 1 / sqrt(K_T) at the best pitch ratio, [Ruth] (3.19): n = m sqrt(T / rho) / D^2."""
        return np.asarray(self._speed(_held(tau)))

    def torque_coefficient(self, tau: ArrayLike) -> FloatArray:
        """Return K_Q at the best pitch ratio, [Ruth] Figure 3.7."""
        return np.asarray(self._torque_coefficient(_held(tau)))


def optimal_maps(model: PropellerModel, pitch_range: tuple[float, float] | None = None) -> OptimalMaps:
    """Return the maps of ``model``, computed once for all propellers alike; see :class:`OptimalMaps`."""
    return _maps_of(_Propeller(model.row().tobytes(), model), pitch_range)


@dataclass(frozen=True)
class _Propeller:
    """A model that is the same as another of the same parameters; the maps do not depend on the diameter."""

    row: bytes
    model: PropellerModel = field(compare=False)


@lru_cache(maxsize=64)
def _maps_of(propeller: _Propeller, pitch_range: tuple[float, float] | None) -> OptimalMaps:
    return OptimalMaps(propeller.model, pitch_range)


def optimal_pitch(model: PropellerModel, tau: ArrayLike, pitch_range: tuple[float, float] | None = None) -> FloatArray:
    """Return the best pitch ratio k(tau), of the shape of ``tau``, computed for these tau rather than looked up.

    Raises
    ------
    InputError
        If a tau is negative or not finite, or as :class:`OptimalMaps`.
    """
    pitch = np.linspace(*thrust_pitches(model, pitch_range), _PITCH_POINTS)
    given = np.asarray(tau, dtype=np.float64)
    J = _advance_number(model, _checked(given).reshape(-1, 1), pitch, _HALVINGS_OF_A_SEARCH)
    K_T, K_Q = model.coefficients(J, pitch)
    cost = np.log(K_Q) - 1.5 * np.log(K_T)
    return _least(pitch, cost).reshape(given.shape)


def advance_number(model: PropellerModel, tau: ArrayLike, pitch_ratio: ArrayLike) -> FloatArray:
    """Return the J with J / sqrt(K_T(J, P/D)) = tau, broadcast over both.

    K_T falls with J, so the left side rises from 0 at J = 0 to infinity where K_T is zero: one root, found by halving.
    A model whose data end before K_T = 0 answers for the end of its data where tau is beyond it.

    Raises
    ------
    InputError
        If a tau is negative or not finite, or a pitch ratio is out of the model's range.
    """
    wanted = _checked(np.asarray(tau, dtype=np.float64))
    return _advance_number(model, wanted, np.asarray(pitch_ratio, dtype=np.float64), _HALVINGS)


def _checked(tau: FloatArray) -> FloatArray:
    if not np.isfinite(tau).all() or (tau < 0.0).any():
        raise InputError(f"tau: expected finite numbers not below 0, found {tau}")
    return tau


def _advance_number(model: PropellerModel, tau: FloatArray, pitch_ratio: FloatArray, halvings: int) -> FloatArray:
    wanted, pitch = np.broadcast_arrays(tau, pitch_ratio)
    low = np.zeros(wanted.shape)
    high = _END * np.minimum(model.advance_number_end(pitch), _FAR)
    for _ in range(halvings):
        J = 0.5 * (low + high)
        K_T, _ = model.coefficients(J, pitch)
        below = wanted * np.sqrt(np.maximum(K_T, 0.0)) > J
        low, high = np.where(below, J, low), np.where(below, high, J)
    # J = 0 is met exactly, or a bollard pull would be none.
    return np.where(wanted == 0.0, 0.0, 0.5 * (low + high))


def efficiency(model: PropellerModel, tau: ArrayLike, pitch_ratio: ArrayLike) -> FloatArray:
    """Return eta_0, [Ruth] (2.23), at ``tau`` and ``pitch_ratio``, broadcast over both. Raises InputError as above."""
    J = advance_number(model, tau, pitch_ratio)
    K_T, K_Q = model.coefficients(J, pitch_ratio)
    return np.asarray(J * K_T / (2.0 * math.pi * K_Q))


def pitch_of_torque_coefficient(
    model: PropellerModel,
    tau: ArrayLike,
    torque_coefficient: float,
    pitch_range: tuple[float, float] | None = None,
) -> FloatArray:
    """Return the pitch ratio at which K_Q(tau, P/D) is ``torque_coefficient``, [Ruth] (3.63); of the shape of ``tau``.

    It is the path of torque/shaft-speed control, [Ruth] 3.4.2. Where no pitch ratio has that K_Q, the end of the
    range that comes nearest is taken, as a saturated pitch actuator does. K_Q rises with P/D.

    Raises
    ------
    InputError
        If a tau is negative or not finite, or as :class:`OptimalMaps`.
    """
    given = _checked(np.asarray(tau, dtype=np.float64))
    least, most = thrust_pitches(model, pitch_range)
    low, high = np.full(given.shape, least), np.full(given.shape, most)

    def excess(pitch: FloatArray) -> FloatArray:
        _, K_Q = model.coefficients(_advance_number(model, given, pitch, _HALVINGS_OF_A_SEARCH), pitch)
        return np.asarray(K_Q - torque_coefficient)

    at_low, at_high = excess(low), excess(high)
    for _ in range(_HALVINGS_OF_A_SEARCH):
        pitch = 0.5 * (low + high)
        below = excess(pitch) < 0.0
        low, high = np.where(below, pitch, low), np.where(below, high, pitch)
    return np.where(at_low >= 0.0, least, np.where(at_high <= 0.0, most, 0.5 * (low + high)))


def pitch_of_thrust_coefficient(
    model: PropellerModel, pitch_range: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return g of [Ruth] (3.16) as a table: rising K_T at J = 0, and the pitch ratios that give it, each shape (m,).

    Raises
    ------
    InputError
        If K_T does not rise with the pitch ratio all over ``pitch_range``, or as :class:`OptimalMaps`.
    """
    pitch = np.linspace(*_pitch_range(model, pitch_range), 2 * _PITCH_POINTS - 1)
    K_T, _ = model.coefficients(0.0, pitch)
    if not (np.diff(K_T) > 0.0).all():
        turn = float(pitch[int(np.argmin(np.diff(K_T) > 0.0))])
        raise InputError(
            f"pitch: expected a thrust coefficient that rises with the pitch ratio from {pitch[0]:g} to {pitch[-1]:g}, "
            f"found that it falls from {turn:.2f} on"
        )
    return K_T, pitch


def thrust_pitches(model: PropellerModel, pitch_range: tuple[float, float] | None = None) -> tuple[float, float]:
    """Return the part of ``pitch_range`` where K_T at J = 0 is above 5 % of its largest.

    Raises
    ------
    InputError
        If that part does not reach to the largest pitch ratio, or as :class:`OptimalMaps`.
    """
    least, most = _pitch_range(model, pitch_range)
    pitch = np.linspace(least, most, 2 * _PITCH_POINTS - 1)
    K_T, _ = model.coefficients(0.0, pitch)
    weak = np.flatnonzero(_LEAST_THRUST * K_T.max() >= K_T)
    if len(weak) == 0:
        return least, most
    if weak[-1] == len(pitch) - 1:
        raise InputError(f"pitch_range: expected a largest pitch ratio that gives thrust, found {pitch_range}")
    return float(pitch[weak[-1] + 1]), most


def _pitch_range(model: PropellerModel, pitch_range: tuple[float, float] | None) -> tuple[float, float]:
    known = model.pitch_range
    if known is None:
        raise InputError("pitch_range: expected a propeller model with a range of pitch ratios, found one pitch")
    if pitch_range is None:
        return known
    least, most = pitch_range
    if not known[0] <= least < most <= known[1]:
        raise InputError(f"pitch_range: expected a range within {known[0]:g} to {known[1]:g}, found {pitch_range}")
    return least, most


def _least(pitch: FloatArray, cost: FloatArray) -> FloatArray:
    """Return where every row of a smooth cost over pitch ratios is least, between the points too."""
    from scipy.interpolate import CubicSpline  # here: its import is slow

    pieces = CubicSpline(pitch, cost, axis=1).c  # (4, pieces, rows), highest power of the distance into a piece first
    rows, nearest = np.arange(len(cost)), np.argmin(cost, axis=1)
    best, least = pitch[nearest], cost[rows, nearest]
    for piece in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(pitch) - 2)):
        a, b, c, d = pieces[:, piece, rows]
        # Of the two stationary points the one where the slope rises; this form of the root bears a = 0.
        with np.errstate(divide="ignore", invalid="ignore"):
            x = -c / (b + np.sqrt(b * b - 3.0 * a * c))
        value = ((a * x + b) * x + c) * x + d
        better = (x >= 0.0) & (x <= pitch[piece + 1] - pitch[piece]) & (value < least)
        best, least = np.where(better, pitch[piece] + x, best), np.where(better, value, least)
    return np.asarray(best)


def _held(tau: ArrayLike) -> FloatArray:
    return np.clip(np.asarray(tau, dtype=np.float64), 0.0, TAU_MAX)
