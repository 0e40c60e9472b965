"""The Wageningen B-series: K_T and K_Q as polynomials in J, P/D, A_E/A_0 and Z."""

from __future__ import annotations

import csv
from functools import cache
from importlib import resources

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number
from marine_model.propellers.base import FirstQuadrantModel
from marine_model.propellers.rows import END_STEPS

BLADES = (2, 7)
AREA_RATIO = (0.3, 1.05)
PITCH_RATIO = (0.5, 1.4)

_POWERS_OF_ADVANCE, _POWERS_OF_PITCH = 4, 7
_FILE = "wageningen_b_series.csv"


class WageningenBPropeller(FirstQuadrantModel):
    """One propeller of the B-series at a Reynolds number of 2e6, first quadrant.

    The polynomials are those of Oosterveld and van Oossanen (1975), printed once more by Bernitsas, Ray and Kinley
    (1981). [Ruth] has the older set of van Lammeren et al. (1969), which differs in the third digit. The range is
    J = 0 up to K_T = 0.

    Parameters
    ----------
    diameter
        D, m.
    blades
        Z, 2 to 7.
    area_ratio
        A_E/A_0, expanded blade area over disc area, 0.3 to 1.05.
    pitch_ratio
        Design pitch ratio P/D, 0.5 to 1.4.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    def __init__(self, diameter: float, blades: int, area_ratio: float, pitch_ratio: float) -> None:
        super().__init__(diameter, pitch_ratio, PITCH_RATIO)
        number = finite_number("blades", blades)
        if number != round(number) or not BLADES[0] <= number <= BLADES[1]:
            raise InputError(f"blades: expected a whole number from {BLADES[0]} to {BLADES[1]}, found {blades!r}")
        area = finite_number("area_ratio", area_ratio)
        if not AREA_RATIO[0] <= area <= AREA_RATIO[1]:
            raise InputError(f"area_ratio: expected a number from {AREA_RATIO[0]} to {AREA_RATIO[1]}, found {area:g}")
        self._thrust, self._torque = (_collapsed(table, round(number), area) for table in _polynomials())
        self._end_guess = self._fitted_end()

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return the advance number of zero thrust."""
        pitch = np.clip(np.asarray(pitch_ratio, dtype=np.float64), *PITCH_RATIO)
        cubic = _in_advance(self._thrust, pitch)
        end = np.asarray(polynomial.polyval(pitch, self._end_guess), dtype=np.float64)
        for _ in range(END_STEPS):
            end = end - _value(cubic, end) / _slope(cubic, end)
        return end

    def row(self) -> FloatArray:
        """Return one piece: a polynomial of degree 3 in J and 6 in P/D, blades and area ratio multiplied out."""
        coefficients = np.stack([self._thrust, self._torque])[None, None]
        guess = tuple(self._end_guess.tolist())
        return self._packed(np.zeros(2), np.zeros(2), coefficients, guess, end_is_zero_thrust=True)

    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = (_value(_in_advance(k, pitch_ratio), advance_number) for k in (self._thrust, self._torque))
        return thrust, torque

    def _slopes(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = (_slope(_in_advance(k, pitch_ratio), advance_number) for k in (self._thrust, self._torque))
        return thrust, torque

    def _fitted_end(self) -> FloatArray:
        """Return a cubic in P/D near the least positive J of K_T = 0, for Newton to start from."""
        pitches = np.linspace(*PITCH_RATIO, 19)
        ends = []
        for pitch in pitches:
            roots = polynomial.polyroots(_in_advance(self._thrust, pitch))
            ends.append(min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0.0))
        return np.asarray(polynomial.polyfit(pitches, ends, 3))


@cache
def _polynomials() -> tuple[FloatArray, FloatArray]:
    """Return the terms of K_T and K_Q, shape (terms, 5): C, s, t, u, v of C J^s (P/D)^t (A_E/A_0)^u Z^v."""
    text = resources.files("marine_model").joinpath("data", _FILE).read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    thrust, torque = (
        np.array([[float(row[key]) for key in "Cstuv"] for row in rows if row["coefficient"] == name])
        for name in ("KT", "KQ")
    )
    return thrust, torque


def _collapsed(terms: FloatArray, blades: int, area_ratio: float) -> FloatArray:
    """Return the coefficients in J (rows) and P/D (columns) of one number of blades and area ratio."""
    C, s, t, u, v = terms.T
    coefficients = np.zeros((_POWERS_OF_ADVANCE, _POWERS_OF_PITCH))
    np.add.at(coefficients, (s.astype(int), t.astype(int)), C * area_ratio**u * float(blades) ** v)
    return coefficients


def _in_advance(coefficients: FloatArray, pitch_ratio: FloatArray) -> FloatArray:
    """Return the coefficients in J at ``pitch_ratio``: shape (4, *shape of pitch_ratio)."""
    return np.asarray(polynomial.polyval(pitch_ratio, coefficients.T))


def _value(cubic: FloatArray, advance_number: FloatArray) -> FloatArray:
    return np.asarray(cubic[0] + advance_number * (cubic[1] + advance_number * (cubic[2] + advance_number * cubic[3])))


def _slope(cubic: FloatArray, advance_number: FloatArray) -> FloatArray:
    return np.asarray(cubic[1] + advance_number * (2.0 * cubic[2] + advance_number * 3.0 * cubic[3]))
