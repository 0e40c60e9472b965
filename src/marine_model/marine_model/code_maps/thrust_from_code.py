"""Thrust of a code at a speed, [Kostenko] (4), Table 2."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import SupportsIndex

from marine_model.code_maps.codes import require_code
from marine_model.code_maps.speeds import Speeds
from marine_model.errors import InputError


class ThrustFromCode:
    """T = K_F0(V) sign N + K_F1(V) N + K_F2(V) N |N|, and 0 in the dead zone.

    The dead zone is where that has not the sign of N. The print has T = 0 for |N| <= K_F0, but K_F0 is a thrust, and
    negative. Its zero instead of |K_F0| leaves the map continuous, and is where the map back, (8), begins.

    The map is odd in the code: it was made for thrust along the motion, and is taken for thrust against it as well.

    Parameters
    ----------
    speeds
        Of the columns.
    constant, linear, quadratic
        K_F0, not above 0, K_F1, above 0, and K_F2, not below 0: N, one a speed.
    code_max
        Largest code.

    Raises
    ------
    InputError
        If coefficients have other signs, or the largest code gives no thrust at a speed.
    """

    def __init__(
        self,
        speeds: Speeds,
        constant: Sequence[float],
        linear: Sequence[float],
        quadratic: Sequence[float],
        code_max: int,
    ) -> None:
        self.speeds = speeds
        self.code_max = code_max
        self._constant = speeds.require_column_each("constant", constant)
        self._linear = speeds.require_column_each("linear", linear)
        self._quadratic = speeds.require_column_each("quadratic", quadratic)
        for i in range(len(speeds)):
            for name, value, good, expected in (
                ("constant", self._constant[i], self._constant[i] <= 0.0, "a number not above 0"),
                ("linear", self._linear[i], self._linear[i] > 0.0, "a number above 0"),
                ("quadratic", self._quadratic[i], self._quadratic[i] >= 0.0, "a number not below 0"),
            ):
                if not good:
                    raise InputError(f"{name}[{i}]: expected {expected}, found {value:g}")
            largest = self._column(i, float(code_max))
            if largest <= 0.0:
                raise InputError(f"constant[{i}]: expected thrust from code {code_max}, found {largest:g} N")

    def thrust(self, code: SupportsIndex, speed: float) -> float:
        """Return the thrust (N) of an integer ``code`` at ``speed`` (m/s).

        Raises
        ------
        InputError
            If the code is not whole or beyond the largest, or the speed is outside the table.
        """
        number = require_code(code, self.code_max)
        return self.at(float(number), speed)

    def at(self, code: float, speed: float) -> float:
        """Return the thrust (N) at a code that need not be whole. Raises InputError as :meth:`thrust`."""
        size = abs(code)
        if not size <= self.code_max:
            raise InputError(f"code: expected a number from {-self.code_max} to {self.code_max}, found {code!r}")
        i, weight = self.speeds.place(speed)
        value = self._column(i, size)
        if weight > 0.0:  # before the dead zone is cut off: its edge moves with the speed and does not jump
            value = (1.0 - weight) * value + weight * self._column(i + 1, size)
        return math.copysign(value, code) if value > 0.0 else 0.0

    def dead_zone(self, speed: float) -> float:
        """Return the largest code, not whole, that gives no thrust. Raises InputError if the speed is outside."""
        c, b, a = (self.speeds.at(row, speed) for row in (self._constant, self._linear, self._quadratic))
        return -2.0 * c / (b + math.sqrt(b * b - 4.0 * a * c))

    def _column(self, i: int, size: float) -> float:
        return self._constant[i] + size * (self._linear[i] + size * self._quadratic[i])
