"""Static map of ventilation: loss factors over shaft speed, pitch and submergence, [Ruth] (2.36)-(2.51).

(2.44)-(2.49) are printed with beta = a F_nh2 + b, a = (F_0.2 - F_0.8) / 0.6, b = F_0.8 - 0.8 a. Taken literally beta
would rise with the shaft speed and miss both of its points: a and b are the straight line of F_nh2 over beta, with the
sign of a turned. What passes through (F_0.8, 0.8) and (F_0.2, 0.2), and is used here, is

    beta = 0.8 - 0.6 (F_nh2 - F_0.8) / (F_0.2 - F_0.8).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled, inlined
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.ventilation.data import VentilationData
from marine_model.ventilation.table import (
    A_02_MINUS,
    A_02_PLUS,
    A_08_MINUS,
    A_08_PLUS,
    A_Q,
    B_02_MINUS,
    B_02_PLUS,
    B_08_MINUS,
    B_08_PLUS,
    B_Q,
    BETA_TW_MAX,
    BETA_TW_MIN,
    HIGH_LOSS_FACTOR,
    LOW_LOSS_FACTOR,
)


@inlined
def wetted_area(submergence_ratio: float) -> float:
    """Return beta_area = A_wet / A_0, [Ruth] (2.39): 0 out of the water, 1 when covered."""
    if submergence_ratio >= 1.0:  # beyond these, the real part of (2.39)
        return 1.0
    if submergence_ratio <= -1.0:
        return 0.0
    x = submergence_ratio
    return max(0.0, 1.0 - math.acos(x) / math.pi + x * math.sqrt(1.0 - x * x) / math.pi)  # not -1e-17


@inlined
def modified_froude_number(shaft_speed: float, diameter: float, pitch_ratio: float, submergence_ratio: float) -> float:
    """Return F_nh2, [Ruth] (2.36), of |n| and |P/D|; infinite out of the water, h/R <= -1."""
    depth = 1.0 + submergence_ratio
    if depth <= 0.0:
        return math.inf
    return abs(shaft_speed * pitch_ratio) * math.sqrt(diameter / (depth * GRAVITY))


@inlined
def thrust_loss(row: FloatArray, froude: float, submergence_ratio: float) -> float:
    """Return beta_Tw, [Ruth] (2.40)-(2.50).

    The minus band counts as long as its 0.2 line lies above its 0.8 line; ``VentilationData`` makes sure that the
    plus band has taken over before.
    """
    least: float = row[BETA_TW_MIN]
    most: float = row[BETA_TW_MAX]
    if submergence_ratio <= -1.0:
        return least
    high: float = row[A_08_PLUS] * submergence_ratio + row[B_08_PLUS]
    width: float = row[A_02_PLUS] * submergence_ratio + row[B_02_PLUS] - high
    beta = HIGH_LOSS_FACTOR - (HIGH_LOSS_FACTOR - LOW_LOSS_FACTOR) * (froude - high) / width
    high = row[A_08_MINUS] * submergence_ratio + row[B_08_MINUS]
    width = row[A_02_MINUS] * submergence_ratio + row[B_02_MINUS] - high
    if width > 0.0:
        other = HIGH_LOSS_FACTOR - (HIGH_LOSS_FACTOR - LOW_LOSS_FACTOR) * (froude - high) / width
        beta = max(beta, other)
    return max(least, min(most, beta))


@inlined
def loss_factors(
    row: FloatArray, shaft_speed: float, diameter: float, pitch_ratio: float, submergence_ratio: float
) -> tuple[float, float, float]:
    """Return (beta_area, beta_Tw, beta_Qw) of one propeller, [Ruth] (2.36)-(2.51).

    beta_T = beta_area beta_Tw and beta_Q = beta_area beta_Qw, (2.37)-(2.38). Out of the water beta_area is 0 and
    beta_Tw is at its minimum: a propeller comes back aired.

    Parameters
    ----------
    row
        ``VentilationData.row()``.
    shaft_speed
        n, Hz; losses depend on |n|.
    diameter
        D, m, above 0.
    pitch_ratio
        P/D; losses depend on its magnitude.
    submergence_ratio
        h/R: depth of the shaft below the surface over the propeller radius; negative above it.
    """
    froude = modified_froude_number(shaft_speed, diameter, pitch_ratio, submergence_ratio)
    thrust = thrust_loss(row, froude, submergence_ratio)
    return wetted_area(submergence_ratio), thrust, row[A_Q] * thrust + row[B_Q]


@compiled
def _loss_factors_of_many(
    row: FloatArray, n: FloatArray, diameter: FloatArray, pitch_ratio: FloatArray, x: FloatArray
) -> FloatArray:
    """Apply ``loss_factors`` along vectors of one length; shape (3, length)."""
    factors = np.empty((3, n.size))
    for i in range(n.size):
        factors[0, i], factors[1, i], factors[2, i] = loss_factors(row, n[i], diameter[i], pitch_ratio[i], x[i])
    return factors


@dataclass(frozen=True, slots=True)
class LossFactors:
    """Loss factors of [Ruth] 2.3.1; arrays of one shape, in [0, 1]."""

    area: FloatArray  # beta_area, wetted share of the disc
    thrust_wetted: FloatArray  # beta_Tw
    torque_wetted: FloatArray  # beta_Qw

    @property
    def thrust(self) -> FloatArray:
        """beta_T = beta_area beta_Tw, (2.37)."""
        return self.area * self.thrust_wetted

    @property
    def torque(self) -> FloatArray:
        """beta_Q = beta_area beta_Qw, (2.38)."""
        return self.area * self.torque_wetted


class VentilationModel:
    """Static map of ventilation for arrays of working points.

    Parameters
    ----------
    data
        Table 2.5 of the propeller.
    """

    def __init__(self, data: VentilationData) -> None:
        self.data = data
        self._row = data.row()

    def loss_factors(
        self,
        shaft_speed: ArrayLike,
        diameter: ArrayLike,
        pitch_ratio: ArrayLike,
        submergence_ratio: ArrayLike,
    ) -> LossFactors:
        """Return the loss factors; see the function ``loss_factors`` for the arguments, which are broadcast.

        Raises
        ------
        InputError
            If a number is not finite, a diameter is not above 0, or the shapes do not fit together.
        """
        given = {
            "shaft_speed": shaft_speed,
            "diameter": diameter,
            "pitch_ratio": pitch_ratio,
            "submergence_ratio": submergence_ratio,
        }
        arrays = {name: np.asarray(value, dtype=np.float64) for name, value in given.items()}
        for name, array in arrays.items():
            if not np.isfinite(array).all():
                raise InputError(f"{name}: expected finite numbers, found {array.tolist()}")
        if (arrays["diameter"] <= 0.0).any():
            raise InputError(f"diameter: expected numbers above 0, found {arrays['diameter'].tolist()}")
        try:
            full = np.broadcast_arrays(*arrays.values())
        except ValueError as error:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
            raise InputError(f"loss_factors: expected shapes that fit together, found {shapes}") from error
        factors = _loss_factors_of_many(self._row, *(np.array(array).ravel() for array in full))
        area, thrust, torque = factors.reshape((3, *full[0].shape))
        return LossFactors(area, thrust, torque)
