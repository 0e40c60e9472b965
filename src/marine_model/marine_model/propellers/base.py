"""What every propeller model answers: coefficients within its range, and forces at any speeds for simulation."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, positive_number
from marine_model.propellers.rows import BREAKS, END, KIND, PIECEWISE, PITCH_MAX, PITCH_MIN

OutOfRange = Literal["error", "clamp"]


class OutOfRangeWarning(UserWarning):
    """A propeller was asked for what it has no data for, and answered for the nearest that it has."""


class PropellerModel(ABC):
    """One propeller in open water.

    Shaft speed n is in Hz, advance number J = V_A / (n D) [Ruth] (2.11), pitch ratio P/D. All methods are vectorised
    over what they are given, by the rules of numpy broadcasting.

    Parameters
    ----------
    diameter
        D, m, above 0.
    pitch_ratio
        Design pitch ratio P/D: what counts where no other is given.
    pitch_range
        Least and largest pitch ratio with data; None if the model knows one pitch.

    Raises
    ------
    InputError
        If a number is not finite, the diameter not above 0, or the design pitch ratio out of range.
    """

    def __init__(self, diameter: float, pitch_ratio: float, pitch_range: tuple[float, float] | None) -> None:
        self._diameter = positive_number("diameter", diameter)
        self._pitch_ratio = positive_number("pitch_ratio", pitch_ratio)
        self._pitch_range = pitch_range
        if pitch_range is not None and not pitch_range[0] <= self._pitch_ratio <= pitch_range[1]:
            raise InputError(f"pitch_ratio: expected {_between(*pitch_range)}, found {self._pitch_ratio:g}")

    @property
    def diameter(self) -> float:
        """D, m."""
        return self._diameter

    @property
    def pitch_ratio(self) -> float:
        """Design pitch ratio P/D."""
        return self._pitch_ratio

    @property
    def pitch_range(self) -> tuple[float, float] | None:
        """Least and largest pitch ratio with data; None if the model knows one pitch."""
        return self._pitch_range

    @property
    def advance_number_range(self) -> tuple[float, float]:
        """Least and largest advance number with data at the design pitch ratio, for n > 0."""
        return self._least_advance_number, float(self.advance_number_end(self._pitch_ratio))

    @abstractmethod
    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        """Return the largest advance number with data at ``pitch_ratio``, which is held to its range."""

    def coefficients(
        self, advance_number: ArrayLike, pitch_ratio: ArrayLike | None = None, out_of_range: OutOfRange = "error"
    ) -> tuple[FloatArray, FloatArray]:
        """Return K_T and K_Q, [Ruth] (2.9)-(2.10), for n > 0.

        Parameters
        ----------
        advance_number
            J, any shape.
        pitch_ratio
            P/D, broadcast with J; the design pitch ratio when None.
        out_of_range
            "error" refuses numbers outside the range of the model; "clamp" answers for the nearest inside and warns.

        Raises
        ------
        InputError
            If a number is not finite, or out of range with "error"; the message has the first such number.

        Warns
        -----
        OutOfRangeWarning
            If a number is out of range with "clamp".
        """
        advance = _finite("advance_number", advance_number)
        pitch = _finite("pitch_ratio", self._pitch_ratio if pitch_ratio is None else pitch_ratio)
        low, high = self._pitch_limits
        pitch = _inside("pitch_ratio", pitch, np.asarray(low), np.asarray(high), out_of_range)
        end = self.advance_number_end(pitch)
        advance = _inside("advance_number", advance, np.asarray(self._least_advance_number), end, out_of_range)
        return self._coefficients(advance, pitch)

    def forces(
        self, shaft_speed: ArrayLike, advance_speed: ArrayLike, density: float, pitch_ratio: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return thrust (N) and torque (N m) at any shaft and advance speed, for simulation.

        Outside its range a first-quadrant model goes on as ``marine_model.propellers.kernel`` says, which gives the
        same numbers one propeller at a time; the pitch ratio is held to its range.

        Parameters
        ----------
        shaft_speed, advance_speed
            n, Hz, and V_A, m/s, of any shape and sign.
        density
            rho, kg/m^3.
        pitch_ratio
            P/D; the design pitch ratio when None.

        Raises
        ------
        InputError
            If a number is not finite, or the density not above 0.
        """
        n = _finite("shaft_speed", shaft_speed)
        speed = _finite("advance_speed", advance_speed)
        pitch = _finite("pitch_ratio", self._pitch_ratio if pitch_ratio is None else pitch_ratio)
        low, high = self._pitch_limits
        return self._forces(n, speed, positive_number("density", density), np.clip(pitch, low, high))

    @abstractmethod
    def row(self) -> FloatArray:
        """Return the packed parameters for ``marine_model.propellers.kernel``, 1-D."""

    @abstractmethod
    def _coefficients(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return K_T and K_Q; everything is in range."""

    @abstractmethod
    def _forces(
        self, shaft_speed: FloatArray, advance_speed: FloatArray, density: float, pitch_ratio: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return thrust and torque; the pitch ratio is in range."""

    @property
    def _least_advance_number(self) -> float:
        return 0.0

    @property
    def _pitch_limits(self) -> tuple[float, float]:
        return self._pitch_range or (self._pitch_ratio, self._pitch_ratio)


class FirstQuadrantModel(PropellerModel):
    """A model of K_T and K_Q for J >= 0 that goes on along tangents outside its range."""

    @abstractmethod
    def _slopes(self, advance_number: FloatArray, pitch_ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dK_T/dJ and dK_Q/dJ; everything is in range."""

    def _forces(
        self, shaft_speed: FloatArray, advance_speed: FloatArray, density: float, pitch_ratio: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        n, speed, pitch = np.broadcast_arrays(shaft_speed, advance_speed, pitch_ratio)
        # At n = 0 J is infinite with the sign of V_A: what counts there is a tangent's slope alone.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            advance = np.where(n == 0.0, np.copysign(np.inf, speed), speed / (n * self.diameter))
        advance = np.where(speed == 0.0, 0.0, advance)
        held = np.clip(advance, 0.0, self.advance_number_end(pitch))
        square, cross = n * np.abs(n), np.abs(n) * speed / self.diameter
        scale = density * self.diameter**4
        thrust, torque = (
            (k - k1 * held) * square + k1 * cross
            for k, k1 in zip(self._coefficients(held, pitch), self._slopes(held, pitch), strict=True)
        )
        return scale * thrust, scale * self.diameter * torque

    def _packed(
        self,
        pitch_breaks: FloatArray,
        advance_breaks: FloatArray,
        coefficients: FloatArray,
        end: tuple[float, float, float, float],
        end_is_zero_thrust: bool = False,
    ) -> FloatArray:
        """Return the row of a piecewise polynomial.

        ``coefficients`` has shape (pitch pieces, advance pieces, 2, 4, pitch terms), see kernel.
        """
        low, high = self._pitch_limits
        head = np.zeros(BREAKS)
        head[[KIND, PITCH_MIN, PITCH_MAX]] = PIECEWISE, low, high
        head[PITCH_MAX + 1 : END] = len(pitch_breaks) - 1, coefficients.shape[-1], len(advance_breaks) - 1
        head[END : END + 4] = end
        head[END + 4] = float(end_is_zero_thrust)
        return np.concatenate([head, pitch_breaks, advance_breaks, np.moveaxis(coefficients, -1, 2).ravel()])


def _finite(name: str, value: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected numbers, found {value!r}") from error
    if not np.isfinite(array).all():
        raise InputError(f"{name}: expected finite numbers, found {array[~np.isfinite(array)].flat[0]}")
    return array


def _inside(name: str, value: FloatArray, low: FloatArray, high: FloatArray, out_of_range: OutOfRange) -> FloatArray:
    """Return ``value`` held to [low, high], or refuse it."""
    value, low, high = np.broadcast_arrays(value, low, high)
    # What a caller computed from the limits themselves may be off by rounding.
    slack = 1e-12 * np.where(np.isfinite(high), np.abs(high), 0.0)
    outside = (value < low - slack) | (value > high + slack)
    if outside.any():
        first = tuple(index[0] for index in np.nonzero(np.atleast_1d(outside)))
        found, least, most = (float(np.atleast_1d(array)[first]) for array in (value, low, high))
        message = f"{name}: expected {_between(least, most)}, found {found:g}"
        if out_of_range == "error":
            raise InputError(message)
        warnings.warn(f"{message}; taken as the nearest limit", OutOfRangeWarning, stacklevel=3)
    return np.clip(value, low, high)


def _between(low: float, high: float) -> str:
    return f"{low:g} (no other is known)" if low == high else f"a number from {low:g} to {high:g}"
