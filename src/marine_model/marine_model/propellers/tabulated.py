"""A propeller known from a table of open-water results."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number
from marine_model.propellers.base import FirstQuadrantModel
from marine_model.propellers.pitch_interpolation import PitchInterpolation

Rows = Sequence[Sequence[float]]
Fault = tuple[tuple[str | int, ...], str]  # field, what was expected and what was found


class TabulatedPropeller(FirstQuadrantModel):
    """K_T and K_Q between the rows of a table: monotone cubics (PCHIP) in J, cubic splines in P/D.

    Parameters
    ----------
    diameter
        D, m.
    pitch_ratio
        Design pitch ratio P/D.
    advance_number
        J of the columns, (j,) with j >= 2: from 0, rising.
    thrust_coefficient, torque_coefficient
        K_T, falling with J, and K_Q, above 0: a row of j numbers for every pitch ratio of the table.
    table_pitch_ratio
        P/D of the rows, rising; None for a table of one row, which is that of the design pitch ratio.

    Raises
    ------
    InputError
        If the table breaks one of these rules: the message names field, row and column, from 0.
    """

    def __init__(
        self,
        diameter: float,
        pitch_ratio: float,
        advance_number: Sequence[float],
        thrust_coefficient: Rows,
        torque_coefficient: Rows,
        table_pitch_ratio: Sequence[float] | None = None,
    ) -> None:
        fault = table_fault(advance_number, thrust_coefficient, torque_coefficient, table_pitch_ratio)
        if fault is not None:
            field, message = fault
            raise InputError(f"{field[0]}{''.join(f'[{index}]' for index in field[1:])}: {message}")
        pitches = np.array([pitch_ratio] if table_pitch_ratio is None else table_pitch_ratio, dtype=np.float64)
        super().__init__(diameter, pitch_ratio, pitch_range(pitches.tolist(), pitch_ratio))
        self._interpolation = PitchInterpolation(pitches)
        self._advance = np.array(advance_number, dtype=np.float64)
        # SciPy is loaded where a table is: observer and controller, which read vessel files, do without.
        from scipy.interpolate import PchipInterpolator

        self._curves = tuple(
            PchipInterpolator(self._advance, np.array(rows, dtype=np.float64), axis=1)
            for rows in (thrust_coefficient, torque_coefficient)
        )

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return the last advance number of the table."""
        return np.full(np.shape(pitch_ratio), self._advance[-1])

    def row(self) -> FloatArray:
        """Return the cubics of every pair of neighbouring J and P/D."""
        # scipy has (power, piece, pitch), highest power first.
        curves = np.stack([np.moveaxis(curve.c[::-1], 2, 0) for curve in self._curves], axis=2)  # pitch, power, (T, Q)
        pieces = self._interpolation.pieces(np.moveaxis(curves, 1, 3))  # pitch piece, (T, Q), J piece, power, term
        pieces = np.moveaxis(pieces, 1, 2)
        end = (float(self._advance[-1]), 0.0, 0.0, 0.0)
        return self._packed(self._interpolation.breaks, self._advance, np.ascontiguousarray(pieces), end)

    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._at(advance_number, pitch_ratio, 0)

    def _slopes(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self._at(advance_number, pitch_ratio, 1)

    def _at(
        self, advance_number: FloatArray, pitch_ratio: FloatArray, derivative: int
    ) -> tuple[FloatArray, FloatArray]:
        advance, pitch = np.broadcast_arrays(advance_number, pitch_ratio)
        weights = np.moveaxis(self._interpolation.weights(pitch), -1, 0)
        thrust, torque = ((curve(advance, derivative) * weights).sum(axis=0) for curve in self._curves)
        return thrust, torque


def pitch_range(known: Sequence[float], design: float) -> tuple[float, float] | None:
    """Return the range of the known pitch ratios; None for one, which must be the design pitch ratio then.

    Raises
    ------
    InputError
        If it is not.
    """
    if len(known) > 1:
        return float(known[0]), float(known[-1])
    if known[0] != finite_number("pitch_ratio", design):
        raise InputError(f"pitch_ratio: expected {known[0]:g}, the one that there is data for, found {design:g}")
    return None


def table_fault(
    advance_number: Sequence[float],
    thrust_coefficient: Rows,
    torque_coefficient: Rows,
    pitch_ratio: Sequence[float] | None,
) -> Fault | None:
    """Return the first rule that a table breaks: field (with row and column, from 0) and message; None if good."""
    if len(advance_number) < 2:
        return ("advance_number",), f"expected at least 2 numbers, found {len(advance_number)}"
    if advance_number[0] != 0.0:
        return ("advance_number", 0), f"expected 0, bollard pull, found {advance_number[0]:g}"
    fault = not_rising("advance_number", advance_number)
    if fault is None and pitch_ratio is not None:
        fault = pitch_fault(pitch_ratio)
    if fault is not None:
        return fault
    rows = 1 if pitch_ratio is None else len(pitch_ratio)
    for name, table in (("thrust_coefficient", thrust_coefficient), ("torque_coefficient", torque_coefficient)):
        fault = shape_fault(name, table, rows, len(advance_number))
        if fault is not None:
            return fault
    for i, row in enumerate(thrust_coefficient):
        if row[0] <= 0.0:
            return ("thrust_coefficient", i, 0), f"expected a number above 0 at J = 0, found {row[0]:g}"
        for k in range(1, len(row)):
            if row[k] >= row[k - 1]:
                return ("thrust_coefficient", i, k), f"expected less than {row[k - 1]:g} before it, found {row[k]:g}"
    for i, row in enumerate(torque_coefficient):
        for k, value in enumerate(row):
            if value <= 0.0:
                return ("torque_coefficient", i, k), f"expected a number above 0, found {value:g}"
    return None


def pitch_fault(pitch_ratio: Sequence[float]) -> Fault | None:
    """Return what is wrong with the pitch ratios of a table: none, one not above 0, or not rising."""
    if not pitch_ratio:
        return ("pitch_ratio",), "expected at least 1 number, found none"
    if not 0.0 < pitch_ratio[0] < math.inf:
        return ("pitch_ratio", 0), f"expected a number above 0, found {pitch_ratio[0]:g}"
    return not_rising("pitch_ratio", pitch_ratio)


def not_rising(name: str, values: Sequence[float]) -> Fault | None:
    """Return the first value that is not above the one before it."""
    for i in range(1, len(values)):
        if not math.inf > values[i] > values[i - 1]:
            return (name, i), f"expected a finite number above {values[i - 1]:g} before it, found {values[i]:g}"
    return None


def shape_fault(name: str, table: Rows, rows: int, columns: int) -> Fault | None:
    """Return the first row of another length, with a number that is not finite, or that rows are missing."""
    if len(table) != rows:
        return (name,), f"expected a row for every pitch ratio, {rows}, found {len(table)}"
    for i, row in enumerate(table):
        if len(row) != columns:
            return (name, i), f"expected {columns} numbers, found {len(row)}"
        for k, value in enumerate(row):
            if not math.isfinite(value):
                return (name, i, k), f"expected a finite number, found {value}"
    return None
