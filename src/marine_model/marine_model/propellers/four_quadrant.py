"""A propeller in all four quadrants: C_T and C_Q as Fourier series of the advance angle, [Ruth] 2.2.3."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.conversion import advance_angle_of, four_quadrant_scale, open_water_coefficients
from marine_model.propellers.pitch_interpolation import PitchInterpolation
from marine_model.propellers.rows import BREAKS, FOURIER, HARMONICS, KIND, PITCH_MAX, PITCH_MIN
from marine_model.propellers.tabulated import Fault, Rows, pitch_fault, pitch_range, shape_fault

SERIES = ("thrust_cosine", "thrust_sine", "torque_cosine", "torque_sine")


class FourQuadrantPropeller(PropellerModel):
    """C(beta) = sum over k of A_k cos(k beta) + B_k sin(k beta), one pair of series for every pitch ratio.

    beta is the advance angle at 0.7 R, [Ruth] (2.12), from -180 to 180 deg (Table 2.1). C_T and C_Q are those of
    (2.13)-(2.14). Between pitch ratios the series are interpolated by cubic splines. K_T and K_Q exist for n > 0, at
    every J.

    Parameters
    ----------
    diameter
        D, m.
    pitch_ratio
        Design pitch ratio P/D.
    series_pitch_ratio
        P/D of the rows, rising.
    thrust_cosine, thrust_sine, torque_cosine, torque_sine
        A_k and B_k of C_T and of C_Q: a row for every pitch ratio, k = 0, 1, 2 ...

    Raises
    ------
    InputError
        If rows differ in length, a number is not finite, or a propeller without advance speed has not the thrust and
        the torque of its sense of rotation.
    """

    def __init__(
        self,
        diameter: float,
        pitch_ratio: float,
        series_pitch_ratio: Sequence[float],
        thrust_cosine: Rows,
        thrust_sine: Rows,
        torque_cosine: Rows,
        torque_sine: Rows,
    ) -> None:
        rows = (thrust_cosine, thrust_sine, torque_cosine, torque_sine)
        fault = series_fault(series_pitch_ratio, *rows)
        if fault is not None:
            field, message = fault
            raise InputError(f"{field[0]}{''.join(f'[{index}]' for index in field[1:])}: {message}")
        super().__init__(diameter, pitch_ratio, pitch_range(series_pitch_ratio, pitch_ratio))
        self._interpolation = PitchInterpolation(np.array(series_pitch_ratio, dtype=np.float64))
        self._series = np.array(rows, dtype=np.float64)  # (4, pitch, harmonic)

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return infinity: the series know every advance number."""
        return np.full(np.shape(pitch_ratio), np.inf)

    @property
    def _least_advance_number(self) -> float:
        return -np.inf

    def four_quadrant_coefficients(
        self, advance_angle: ArrayLike, pitch_ratio: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return C_T and C_Q at ``advance_angle`` (rad); the pitch ratio is held to its range."""
        pitch = np.clip(np.asarray(self.pitch_ratio if pitch_ratio is None else pitch_ratio), *self._pitch_limits)
        return self._at(np.asarray(advance_angle, dtype=np.float64), pitch)

    def row(self) -> FloatArray:
        """Return the series, their coefficients as polynomials in the pitch ratio."""
        pieces = self._interpolation.pieces(np.moveaxis(self._series, 0, 2))  # pitch piece, harmonic, series, term
        head = np.zeros(BREAKS)
        head[[KIND, PITCH_MIN, PITCH_MAX]] = FOURIER, *self._pitch_limits
        head[PITCH_MAX + 1 : HARMONICS + 1] = len(pieces), pieces.shape[-1], self._series.shape[-1]
        return np.concatenate([head, self._interpolation.breaks, np.moveaxis(pieces, -1, 2).ravel()])

    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        thrust, torque = self._at(advance_angle_of(advance_number), pitch_ratio)
        return open_water_coefficients(thrust, advance_number), open_water_coefficients(torque, advance_number)

    def _forces(
        self, shaft_speed: FloatArray, advance_speed: FloatArray, density: float, pitch_ratio: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        rotation = 0.7 * np.pi * shaft_speed * self.diameter
        thrust, torque = self._at(np.arctan2(advance_speed, rotation), pitch_ratio)
        scale = four_quadrant_scale(shaft_speed, advance_speed, self.diameter, density)
        return scale * thrust, scale * self.diameter * torque

    def _at(self, advance_angle: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        angle, pitch = np.broadcast_arrays(advance_angle, pitch_ratio)
        weights = self._interpolation.weights(pitch)
        phase = angle[..., None] * np.arange(self._series.shape[-1])
        cosine, sine = np.cos(phase), np.sin(phase)
        at, bt, aq, bq = (weights @ series for series in self._series)
        return (at * cosine + bt * sine).sum(axis=-1), (aq * cosine + bq * sine).sum(axis=-1)


def series_fault(pitch_ratio: Sequence[float], *rows: Rows) -> Fault | None:
    """Return the first rule that series break: field (with row and column, from 0) and message; None if good.

    ``rows`` are thrust_cosine, thrust_sine, torque_cosine and torque_sine.
    """
    fault = pitch_fault(pitch_ratio)
    if fault is not None:
        return fault
    harmonics = len(rows[0][0]) if rows[0] else 0
    for name, table in zip(SERIES, rows, strict=True):
        fault = shape_fault(name, table, len(pitch_ratio), max(harmonics, 1))
        if fault is not None:
            return fault
    for name, table in ((SERIES[0], rows[0]), (SERIES[2], rows[2])):
        for i, row in enumerate(table):
            ahead, astern = sum(row), sum(row[::2]) - sum(row[1::2])
            if not (ahead > 0.0 and astern < 0.0):
                symbol = "C_T" if name == SERIES[0] else "C_Q"
                return (name, i), (
                    f"expected {symbol} above 0 at 0 deg and below 0 at 180 deg (no advance speed), "
                    f"found {ahead:g} and {astern:g}"
                )
    return None
