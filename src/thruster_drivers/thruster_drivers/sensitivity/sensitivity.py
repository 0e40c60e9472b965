"""What a sensitivity is, and the coefficients that a controller reckons with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel


@dataclass(frozen=True)
class Sensitivity:
    """Actual over desired values, arrays of one shape; NaN where the controller has no equilibrium in range.

    Attributes
    ----------
    advance_number, pitch_ratio
        J and P/D at which the propeller runs.
    desired_loading
        tau_d, [Ruth] (2.31).
    shaft_speed
        sn = n / n_d, (3.25).
    thrust
        st = T / T_d, (3.26).
    torque
        sq = Q_p / Q_d, (3.27).
    power
        sp = P / P_d, (3.28).
    """

    advance_number: FloatArray
    pitch_ratio: FloatArray
    desired_loading: FloatArray
    shaft_speed: FloatArray
    thrust: FloatArray
    torque: FloatArray
    power: FloatArray


class NominalCoefficients(NamedTuple):
    """K_Tc and K_Qc, with which a controller turns thrust into shaft speed, torque and power, (3.4)-(3.5)."""

    thrust: float
    torque: float


def nominal_coefficients(model: PropellerModel, pitch_ratio: float | None = None) -> NominalCoefficients:
    """Return K_T and K_Q at J = 0 and ``pitch_ratio``, the design one when None, [Ruth] (3.4)-(3.5)."""
    K_T, K_Q = model.coefficients(0.0, pitch_ratio)
    return NominalCoefficients(float(K_T), float(K_Q))
