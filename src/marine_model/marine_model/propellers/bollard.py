"""One propeller known near bollard pull: constants, or linear in the advance number, [Ruth] (3.4)-(3.7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, positive_number
from marine_model.propellers.base import FirstQuadrantModel
from marine_model.propellers.rows import KIND, LINEAR


class BollardPropeller(FirstQuadrantModel):
    """K_T = K_T0 + a_T J and K_Q = K_Q0 + a_Q J, [Ruth] (3.6)-(3.7), at one pitch.

    Its range reaches from J = 0 to where the first of the two is zero; without slopes it is J = 0 alone. The forces
    are linear in J everywhere.

    Parameters
    ----------
    diameter, pitch_ratio
        D, m, and P/D.
    thrust_coefficient, torque_coefficient
        K_T0 and K_Q0 at J = 0, above 0.
    thrust_slope, torque_slope
        a_T and a_Q, not above 0.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    def __init__(
        self,
        diameter: float,
        pitch_ratio: float,
        thrust_coefficient: float,
        torque_coefficient: float,
        thrust_slope: float = 0.0,
        torque_slope: float = 0.0,
    ) -> None:
        super().__init__(diameter, pitch_ratio, None)
        self._at_rest = (
            positive_number("thrust_coefficient", thrust_coefficient),
            positive_number("torque_coefficient", torque_coefficient),
        )
        self._slope = (_not_above_zero("thrust_slope", thrust_slope), _not_above_zero("torque_slope", torque_slope))
        ends = [-k / slope for k, slope in zip(self._at_rest, self._slope, strict=True) if slope < 0.0]
        self._end = min(ends, default=0.0)

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return where K_T or K_Q is zero; 0 without slopes."""
        return np.full(np.shape(pitch_ratio), self._end)

    def row(self) -> FloatArray:
        """Return one piece, linear in J for all J >= 0: beyond the end it is its own tangent."""
        coefficients = np.zeros((1, 1, 2, 4, 1))
        coefficients[0, 0, :, 0, 0] = self._at_rest
        coefficients[0, 0, :, 1, 0] = self._slope
        row = self._packed(np.zeros(2), np.zeros(2), coefficients, (self._end, 0.0, 0.0, 0.0))
        row[KIND] = LINEAR
        return row

    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = (k + slope * advance_number for k, slope in zip(self._at_rest, self._slope, strict=True))
        return thrust, torque

    def _slopes(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = (np.full(np.shape(advance_number), slope) for slope in self._slope)
        return thrust, torque


def _not_above_zero(name: str, value: float) -> float:
    number = finite_number(name, value)
    if number > 0.0:
        raise InputError(f"{name}: expected a number not above 0, found {number:g}")
    return number
