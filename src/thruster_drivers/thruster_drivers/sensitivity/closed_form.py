"""Sensitivity functions in closed form, [Ruth] (3.29)-(3.66).

All are given over the advance number J, which fixes tau = J / sqrt(K_T); :func:`at_desired_loading` turns that into
functions of tau_d.

The laws for fixed pitch differ in one number. With x = K_Q / K_Qc they have

    sn = x^-kappa,  st = (K_T / K_Tc) x^(-2 kappa),  sq = x^(1 - 2 kappa),  sp = x^(1 - 3 kappa),

with kappa = 0 for shaft-speed, 1/2 for torque, 1/3 for power and (2 + alpha) / 6 for combined control. The last one is
(3.47)-(3.54): its four exponents come from one kappa, as (3.25)-(3.28) ask, once (3.53) is read with K_Qc above K_Q; as
printed, with K_Q above, it contradicts (3.39) and (3.28).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel
from marine_model.root import rising_root
from thruster_drivers.sensitivity.sensitivity import NominalCoefficients, Sensitivity, nominal_coefficients

Law = Callable[[FloatArray], Sensitivity]


def shaft_speed(
    model: PropellerModel,
    advance_number: ArrayLike,
    pitch_ratio: float | None = None,
    nominal: NominalCoefficients | None = None,
) -> Sensitivity:
    """Return the sensitivities of shaft-speed control, [Ruth] (3.29)-(3.33).

    Parameters
    ----------
    model
        The propeller.
    advance_number
        J, any shape, within the range of the model.
    pitch_ratio
        P/D at which it is held; None for the design pitch ratio.
    nominal
        K_Tc and K_Qc; None for those of the model at J = 0, (3.4)-(3.5).

    Raises
    ------
    InputError
        If the model refuses an argument.
    """
    return _fixed_pitch(model, advance_number, pitch_ratio, nominal, 0.0)


def torque(
    model: PropellerModel,
    advance_number: ArrayLike,
    pitch_ratio: float | None = None,
    nominal: NominalCoefficients | None = None,
) -> Sensitivity:
    """Return the sensitivities of torque control, [Ruth] (3.34)-(3.39); arguments as in :func:`shaft_speed`."""
    return _fixed_pitch(model, advance_number, pitch_ratio, nominal, 1.0 / 2.0)


def power(
    model: PropellerModel,
    advance_number: ArrayLike,
    pitch_ratio: float | None = None,
    nominal: NominalCoefficients | None = None,
) -> Sensitivity:
    """Return the sensitivities of power control, [Ruth] (3.40)-(3.45); arguments as in :func:`shaft_speed`."""
    return _fixed_pitch(model, advance_number, pitch_ratio, nominal, 1.0 / 3.0)


def combined(
    model: PropellerModel,
    advance_number: ArrayLike,
    weight: ArrayLike,
    pitch_ratio: float | None = None,
    nominal: NominalCoefficients | None = None,
) -> Sensitivity:
    """Return the approximate sensitivities of combined control, [Ruth] (3.46)-(3.54).

    Exact at weights 0 and 1. In between the law x sn^3 = alpha sn + 1 - alpha has the slope -1 / (3 - alpha) at x = 1,
    where this takes -(2 + alpha) / 6. Arguments as in :func:`shaft_speed`, and ``weight``: alpha, the share of torque
    control at the actual shaft speed, 0 to 1, broadcast with ``advance_number``.

    Raises
    ------
    InputError
        If the weight is outside 0 to 1, or the model refuses an argument.
    """
    alpha = np.asarray(weight, dtype=np.float64)
    if not np.all((alpha >= 0.0) & (alpha <= 1.0)):
        raise InputError(f"weight: expected numbers from 0 to 1, found {alpha.tolist()}")
    return _fixed_pitch(model, advance_number, pitch_ratio, nominal, (2.0 + alpha) / 6.0)


def pitch(model: PropellerModel, advance_number: ArrayLike, pitch_ratio: ArrayLike) -> Sensitivity:
    """Return the sensitivities of pitch control, [Ruth] (3.55)-(3.59).

    Parameters
    ----------
    model
        The propeller.
    advance_number
        J at the constant shaft speed, any shape.
    pitch_ratio
        P/D = g(K_Td), the one that gives the desired thrust at J = 0; broadcast with ``advance_number``. With the
        shaft speed free to choose it is a second variable: the sensitivities fill an area, not a line.

    Raises
    ------
    InputError
        If the model refuses an argument, or has no thrust at rest at a pitch ratio.
    """
    J, ratio = np.broadcast_arrays(
        np.asarray(advance_number, dtype=np.float64), np.asarray(pitch_ratio, dtype=np.float64)
    )
    K_Tc, K_Qc = model.coefficients(np.zeros(J.shape), ratio)
    if np.any(K_Tc <= 0.0):
        raise InputError(f"pitch_ratio: expected thrust at J = 0, found K_T = {K_Tc.min()}")
    K_T, K_Q = model.coefficients(J, ratio)
    return _sensitivity(J, ratio, K_Tc, np.ones(J.shape), K_T / K_Tc, K_Q / K_Qc)


def torque_shaft_speed(
    model: PropellerModel,
    advance_number: ArrayLike,
    torque_coefficient: float,
    nominal_thrust: float | None = None,
) -> Sensitivity:
    """Return the sensitivities of torque/shaft-speed control, [Ruth] (3.60)-(3.66).

    Parameters
    ----------
    model
        The propeller, of controllable pitch.
    advance_number
        J, any shape.
    torque_coefficient
        K_Qc, at which the pitch holds the propeller, (3.63).
    nominal_thrust
        K_Tc; None for K_T at J = 0 and the pitch ratio that has K_Qc there.

    Returns
    -------
    Sensitivity
        NaN where no pitch ratio in range has that torque coefficient: the thesis assumes that pitch does not saturate.

    Raises
    ------
    InputError
        If the pitch is fixed, or no pitch ratio has that torque coefficient at J = 0.
    """
    J = np.asarray(advance_number, dtype=np.float64)
    if nominal_thrust is None:
        at_rest = float(pitch_for_torque(model, 0.0, torque_coefficient))
        if np.isnan(at_rest):
            raise InputError(
                f"torque_coefficient: expected one that a pitch ratio has at J = 0, found {torque_coefficient}"
            )
        nominal_thrust = float(model.coefficients(0.0, at_rest)[0])
    ratio = pitch_for_torque(model, J, torque_coefficient)
    thrust = np.full(J.shape, np.nan)
    known = np.isfinite(ratio)
    thrust[known] = model.coefficients(J[known], ratio[known])[0] / nominal_thrust
    one = np.where(known, 1.0, np.nan)
    return _sensitivity(J, ratio, np.asarray(nominal_thrust), one, thrust, one)


def pitch_for_torque(model: PropellerModel, advance_number: ArrayLike, torque_coefficient: float) -> FloatArray:
    """Return the pitch ratio at which K_Q(J, P/D) is ``torque_coefficient``, (3.63); NaN where none in range is.

    Raises
    ------
    InputError
        If the pitch is fixed.
    """
    if model.pitch_range is None:
        raise InputError("propeller: expected one of controllable pitch, found a fixed pitch")
    J = np.asarray(advance_number, dtype=np.float64)
    low, high = model.pitch_range

    def excess(ratio: FloatArray) -> FloatArray:
        # Beyond the data of a low pitch ratio: at their end, where K_Q is less still than what is looked for.
        known = np.minimum(J, model.advance_number_end(ratio))
        return np.asarray(model.coefficients(known, ratio)[1] - torque_coefficient)

    least, most = np.full(J.shape, low), np.full(J.shape, high)
    ratio = rising_root(excess, least, most)
    inside = (excess(least) <= 0.0) & (excess(most) >= 0.0) & (model.advance_number_end(ratio) >= J)
    return np.where(inside, ratio, np.nan)


def at_desired_loading(law: Law, desired_loading: ArrayLike, last_advance_number: float) -> Sensitivity:
    """Return the sensitivities of ``law`` at tau_d.

    Parameters
    ----------
    law
        Any of the functions above with its other arguments bound: J to sensitivities.
    desired_loading
        tau_d, at least 0, any shape.
    last_advance_number
        Where to end, e.g. where thrust is zero. tau_d must rise with J up to there.

    Returns
    -------
    Sensitivity
        NaN beyond the tau_d of ``last_advance_number``.

    Raises
    ------
    InputError
        If the law has no equilibrium at ``last_advance_number``.
    """
    tau_d = np.asarray(desired_loading, dtype=np.float64)
    last = float(law(np.array(last_advance_number)).desired_loading)
    if not np.isfinite(last):
        raise InputError(f"last_advance_number: expected an equilibrium there, found none at J = {last_advance_number}")
    known = (tau_d >= 0.0) & (tau_d <= last)
    wanted = np.where(known, tau_d, 0.0)
    found = law(rising_root(lambda J: law(J).desired_loading - wanted, np.zeros(tau_d.shape), last_advance_number))
    return Sensitivity(
        *(
            np.where(known, value, np.nan)
            for value in (
                found.advance_number,
                found.pitch_ratio,
                found.desired_loading,
                found.shaft_speed,
                found.thrust,
                found.torque,
                found.power,
            )
        )
    )


def _fixed_pitch(
    model: PropellerModel,
    advance_number: ArrayLike,
    pitch_ratio: float | None,
    nominal: NominalCoefficients | None,
    exponent: ArrayLike,
) -> Sensitivity:
    """Return the sensitivities for sn = (K_Qc / K_Q)^exponent."""
    ratio = model.pitch_ratio if pitch_ratio is None else pitch_ratio
    K_Tc, K_Qc = nominal_coefficients(model, ratio) if nominal is None else nominal
    J, kappa = np.broadcast_arrays(np.asarray(advance_number, dtype=np.float64), np.asarray(exponent, dtype=np.float64))
    K_T, K_Q = model.coefficients(J, ratio)
    speed = (K_Qc / K_Q) ** kappa
    return _sensitivity(
        J, np.full(J.shape, ratio), np.asarray(K_Tc), speed, K_T / K_Tc * speed**2, K_Q / K_Qc * speed**2
    )


def _sensitivity(
    J: FloatArray, ratio: FloatArray, K_Tc: FloatArray, speed: FloatArray, thrust: FloatArray, torque: FloatArray
) -> Sensitivity:
    # tau_d = tau sqrt(st) = J / sqrt(K_T) sqrt(K_T / K_Tc) sn: written so that it holds at zero thrust too.
    return Sensitivity(J, ratio, np.asarray(J * speed / np.sqrt(K_Tc)), speed, thrust, torque, speed * torque)
