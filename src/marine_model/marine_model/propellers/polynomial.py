"""A propeller whose coefficients are quadratic in the advance number, [Kostenko] (2)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector, positive_number
from marine_model.propellers.base import FirstQuadrantModel

_TERMS = 3


class PolynomialPropeller(FirstQuadrantModel):
    """K_T = K_T0 + K_T1 J + K_T2 J^2 and K_Q = K_M0 + K_M1 J + K_M2 J^2, [Kostenko] (2), at one pitch.

    Its range reaches from J = 0 to where the first of the two is zero. Outside it goes on along tangents, and with
    n < 0 by odd symmetry, as every first-quadrant model does.

    Parameters
    ----------
    diameter, pitch_ratio
        D, m, and P/D.
    thrust_polynomial, torque_polynomial
        Three coefficients each, lowest power first.

    Raises
    ------
    InputError
        If a number is not finite, a coefficient at J = 0 not above 0, or a polynomial does not fall all the way to the
        end of the range: then it is no propeller's.
    """

    def __init__(
        self,
        diameter: float,
        pitch_ratio: float,
        thrust_polynomial: Sequence[float],
        torque_polynomial: Sequence[float],
    ) -> None:
        super().__init__(diameter, pitch_ratio, None)
        given = {"thrust_polynomial": thrust_polynomial, "torque_polynomial": torque_polynomial}
        self._polynomials: list[tuple[float, float, float]] = []
        for name, values in given.items():
            k0, k1, k2 = finite_vector(name, values, _TERMS).tolist()
            positive_number(f"{name}[0]", k0)
            self._polynomials.append((k0, k1, k2))
        self._end = min(_first_zero(polynomial) for polynomial in self._polynomials)
        if math.isinf(self._end):
            raise InputError(
                "thrust_polynomial: expected one that falls to 0, or such a torque_polynomial, found neither"
            )
        for name, (_, k1, k2) in zip(given, self._polynomials, strict=True):
            steepest = max(k1, k1 + 2.0 * k2 * self._end)
            if steepest > 0.0:
                raise InputError(
                    f"{name}: expected one that falls from J = 0 to J = {self._end:.4g}, "
                    f"found a slope of {steepest:.4g}"
                )

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return where K_T or K_Q is zero."""
        return np.full(np.shape(pitch_ratio), self._end)

    def row(self) -> FloatArray:
        """Return one piece without a cubic term."""
        coefficients = np.zeros((1, 1, 2, 4, 1))
        coefficients[0, 0, :, :_TERMS, 0] = self._polynomials
        end = (self._end, 0.0, 0.0, 0.0)
        return self._packed(np.zeros(2), np.array([0.0, self._end]), coefficients, end)

    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        J = advance_number
        thrust, torque = (k0 + J * (k1 + J * k2) for k0, k1, k2 in self._polynomials)
        return thrust, torque

    def _slopes(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = (k1 + 2.0 * k2 * advance_number for _, k1, k2 in self._polynomials)
        return thrust, torque


def _first_zero(polynomial: tuple[float, float, float]) -> float:
    """Return the least J above 0 where k0 + k1 J + k2 J^2 is zero, with k0 > 0; infinite where there is none."""
    k0, k1, k2 = polynomial
    square = k1 * k1 - 4.0 * k0 * k2
    # 2 k0 over this: no digits are lost where k1 < 0, and k2 = 0 needs no case of its own.
    denominator = -k1 + math.sqrt(square) if square >= 0.0 else 0.0
    return 2.0 * k0 / denominator if denominator > 0.0 else math.inf
