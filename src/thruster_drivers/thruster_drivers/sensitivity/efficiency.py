"""Efficiency of each controller beside the best one, as a function of tau: [Ruth] 3.4.2, 3.6, Table 3.3.

What counts is the pitch ratio at which a controller ends up when the propeller gives its thrust at that tau:
controllers that hold the pitch are equally efficient, whatever they do to the shaft.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from marine_model.errors import InputError
from marine_model.guards import FloatArray, positive_number
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.loading import loading_from_coefficients
from marine_model.propellers.optimal import advance_number, efficiency, optimal_pitch, pitch_of_torque_coefficient
from marine_model.propellers.zero_thrust import last_advance_number
from marine_model.root import rising_root

Range = tuple[float, float] | None

_PITCHES = 181  # of a table; at most 0.005 apart in P/D


@dataclass(frozen=True)
class Path:
    """Efficiency along the (tau, P/D) that a controller takes; arrays of one shape.

    Attributes
    ----------
    loading, pitch_ratio
        tau and P/D.
    efficiency, best
        eta_0 there, and that of the best pitch ratio at the same tau.
    relative_error
        1 - eta_0 / eta_0,optimal; at tau = 0, where both are zero, its limit, which is that of the power.
    """

    loading: FloatArray
    pitch_ratio: FloatArray
    efficiency: FloatArray
    best: FloatArray
    relative_error: FloatArray

    def up_to(self, loading: float) -> Path:
        """Return the part with tau up to ``loading``."""
        keep = self.loading <= loading
        return Path(
            *(
                values[keep]
                for values in (self.loading, self.pitch_ratio, self.efficiency, self.best, self.relative_error)
            )
        )

    @property
    def absolute(self) -> float:
        """Largest loss of efficiency, the norm of eta_0 - eta_0,optimal."""
        return float(np.max(np.abs(self.best - self.efficiency)))

    @property
    def relative(self) -> float:
        """Largest relative loss of efficiency, the norm of 1 - eta_0 / eta_0,optimal."""
        return float(np.max(np.abs(self.relative_error)))


@dataclass(frozen=True)
class Misjudged:
    """What a torque/pitch controller has wrong, as a factor on the truth; the errors of [Ruth] 3.6 by default."""

    thrust_coefficient: float = 0.9
    torque_coefficient: float = 1.1
    advance_speed: float = 1.2

    def __post_init__(self) -> None:
        for name in ("thrust_coefficient", "torque_coefficient", "advance_speed"):
            positive_number(name, getattr(self, name))


def best_path(model: PropellerModel, loading: ArrayLike, pitch_range: Range = None) -> Path:
    """Return the path of the best pitch ratio, which errs nowhere.

    Parameters
    ----------
    model
        The propeller, of controllable pitch.
    loading
        tau, at least 0.
    pitch_range
        Least and largest P/D of the actuator; those of the model when None.

    Raises
    ------
    InputError
        If the pitch is fixed or tau is refused.
    """
    tau = np.asarray(loading, dtype=np.float64)
    best = np.array(_best_pitch(model, tuple(tau.ravel().tolist()), pitch_range)).reshape(tau.shape)
    return _path(model, tau, best, pitch_range)


def fixed_pitch(model: PropellerModel, loading: ArrayLike, pitch_ratio: float, pitch_range: Range = None) -> Path:
    """Return the path at one pitch ratio: every controller that does not move the pitch. As :func:`best_path`."""
    tau = np.asarray(loading, dtype=np.float64)
    return _path(model, tau, np.full(tau.shape, pitch_ratio), pitch_range)


def torque_shaft_speed(
    model: PropellerModel, loading: ArrayLike, torque_coefficient: float, pitch_range: Range = None
) -> Path:
    """Return the path of torque/shaft-speed control with K_Qc, [Ruth] (3.63).

    Where the pitch ratio that has K_Qc is out of range it stays at the nearest limit. Otherwise as :func:`best_path`.
    """
    K_Qc = positive_number("torque_coefficient", torque_coefficient)
    return _path(model, loading, pitch_of_torque_coefficient(model, loading, K_Qc, pitch_range), pitch_range)


def least_error_torque_coefficient(model: PropellerModel, loading: ArrayLike, pitch_range: Range = None) -> float:
    """Return the K_Qc whose largest relative loss of efficiency over ``loading`` is least, 0.033 in [Ruth] 3.4.2.

    Found on a table over pitch ratios, to about 1e-5. As :func:`best_path`.
    """
    tau = np.asarray(loading, dtype=np.float64).ravel()
    pitch = np.linspace(*(pitch_range or _known_range(model)), _PITCHES)
    K_T, K_Q = model.coefficients(advance_number(model, tau[:, np.newaxis], pitch), pitch)
    merit = K_T**1.5 / K_Q
    best = merit.max(axis=1)

    def worst(K_Qc: float) -> float:
        there = [np.interp(K_Qc, K_Q[i], merit[i]) for i in range(len(tau))]  # held to the limits of pitch
        return float(np.max(1.0 - np.array(there) / best))

    found = minimize_scalar(
        worst, bounds=(float(K_Q.min()), float(K_Q.max())), method="bounded", options={"xatol": 1e-7}
    )
    return float(found.x)


def best_torque_coefficient(model: PropellerModel, loading: ArrayLike, pitch_range: Range = None) -> FloatArray:
    """Return K_Q of the best pitch ratio at tau, [Ruth] Figure 3.7. As :func:`best_path`."""
    pitch = optimal_pitch(model, loading, pitch_range)
    return np.asarray(model.coefficients(advance_number(model, loading, pitch), pitch)[1])


def torque_pitch(
    model: PropellerModel, loading: ArrayLike, wrong: Misjudged | None = None, pitch_range: Range = None
) -> Path:
    """Return the path of torque/pitch control that knows the thrust, [Ruth] (3.17)-(3.18), Table 3.2.

    Its best pitch is that of a model with wrong coefficients: with K_T wrong by f_T the model sees the tau of
    sqrt(f_T) tau' as its own, and tau' is wrong by f_V. So P/D = k(f_V sqrt(f_T) tau). A constant factor on K_Q does
    not move the best pitch.

    Parameters
    ----------
    model, loading, pitch_range
        As in :func:`best_path`.
    wrong
        What the controller has wrong; the errors of [Ruth] 3.6 when None.
    """
    tau, wrong = np.asarray(loading, dtype=np.float64), wrong or Misjudged()
    believed = wrong.advance_speed * np.sqrt(wrong.thrust_coefficient) * tau
    return _path(model, tau, optimal_pitch(model, believed, pitch_range), pitch_range)


def torque_pitch_from_demand(
    model: PropellerModel, desired_loading: ArrayLike, wrong: Misjudged | None = None, pitch_range: Range = None
) -> Path:
    """Return the path of torque/pitch control that takes the thrust for the one it asked for.

    tau' = f_V tau_d and Q_c = h'(tau') D T_d with h' = (f_Q / f_T) h. The propeller comes to rest where it takes that
    torque: J sqrt(h' / K_Q(J, P/D)) = tau_d. Too much torque gives too much thrust, and so a true tau below tau_d, for
    which the pitch is still further off.

    Parameters
    ----------
    model, pitch_range
        As in :func:`best_path`.
    desired_loading
        tau_d, at least 0. The path has the true tau, and ends where the propeller would lose its thrust.
    wrong
        What the controller has wrong; the errors of [Ruth] 3.6 when None.
    """
    tau_d, wrong = np.atleast_1d(np.asarray(desired_loading, dtype=np.float64)), wrong or Misjudged()
    believed = wrong.advance_speed * np.sqrt(wrong.thrust_coefficient) * tau_d
    pitch = np.asarray(optimal_pitch(model, believed, pitch_range))
    K_T, K_Q = model.coefficients(advance_number(model, believed, pitch), pitch)
    h = wrong.torque_coefficient / wrong.thrust_coefficient * K_Q / K_T

    # Where torque is short even at the end of the thrust, there is no equilibrium with thrust.
    end = last_advance_number(model, pitch)
    inside = end**2 * h > tau_d**2 * model.coefficients(end, pitch)[1]
    tau_d, pitch, h = tau_d[inside], pitch[inside], h[inside]
    J = rising_root(lambda j: j**2 * h - tau_d**2 * model.coefficients(j, pitch)[1], np.zeros(tau_d.shape), end[inside])
    return _path(model, loading_from_coefficients(J, model.coefficients(J, pitch)[0]), pitch, pitch_range)


def _path(model: PropellerModel, loading: ArrayLike, pitch_ratio: FloatArray, pitch_range: Range) -> Path:
    tau = np.asarray(loading, dtype=np.float64)
    best = np.array(_best_pitch(model, tuple(tau.ravel().tolist()), pitch_range)).reshape(tau.shape)
    # eta_0 = tau / (2 pi) K_T^(3/2) / K_Q: their ratio at one tau is that of what does not vanish at tau = 0.
    ratio = _merit(model, tau, pitch_ratio) / _merit(model, tau, best)
    return Path(tau, pitch_ratio, efficiency(model, tau, pitch_ratio), efficiency(model, tau, best), 1.0 - ratio)


@lru_cache(maxsize=8)
def _best_pitch(model: PropellerModel, loading: tuple[float, ...], pitch_range: Range) -> tuple[float, ...]:
    """Return k(tau): controllers are compared at the same tau."""
    return tuple(optimal_pitch(model, loading, pitch_range).tolist())


def _merit(model: PropellerModel, tau: FloatArray, pitch_ratio: FloatArray) -> FloatArray:
    K_T, K_Q = model.coefficients(advance_number(model, tau, pitch_ratio), pitch_ratio)
    return np.asarray(K_T**1.5 / K_Q)


def _known_range(model: PropellerModel) -> tuple[float, float]:
    if model.pitch_range is None:
        raise InputError("propeller: expected one of controllable pitch, found a fixed pitch")
    return model.pitch_range
