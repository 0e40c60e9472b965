"""The speeds that maps are tabulated at, and what holds between them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from marine_model.errors import InputError
from marine_model.guards import finite_number


class Speeds:
    """Speeds through the water of the columns of a table.

    Between two of them a map has the mean of its values at both, weighted linearly: exact at the tabulated speeds,
    continuous, and rising in its argument where both are. Maps here are linear in their coefficients, so that the same
    comes of weighting the coefficients.

    Parameters
    ----------
    speeds
        m/s, rising, from 0, two or more.

    Raises
    ------
    InputError
        If they are not that.
    """

    def __init__(self, speeds: Sequence[float]) -> None:
        self._speeds = tuple(finite_number(f"speed[{i}]", speed) for i, speed in enumerate(speeds))
        if len(self._speeds) < 2:
            raise InputError(f"speed: expected at least 2 numbers, found {len(self._speeds)}")
        if self._speeds[0] != 0.0:
            raise InputError(f"speed[0]: expected 0, found {self._speeds[0]:g}")
        for i in range(1, len(self._speeds)):
            if self._speeds[i] <= self._speeds[i - 1]:
                raise InputError(
                    f"speed[{i}]: expected a number above {self._speeds[i - 1]:g} before it, found {self._speeds[i]:g}"
                )

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._speeds)

    @property
    def tabulated(self) -> tuple[float, ...]:
        """m/s."""
        return self._speeds

    @property
    def largest(self) -> float:
        """m/s."""
        return self._speeds[-1]

    def place(self, speed: float) -> tuple[int, float]:
        """Return the column at or below ``speed`` (m/s) and the weight of the next one, from 0 to below 1.

        Raises
        ------
        InputError
            If the speed is not finite or outside the tabulated ones; see :meth:`clamp` for a noisy one.
        """
        if not 0.0 <= speed <= self._speeds[-1]:
            raise InputError(f"speed: expected a number from 0 to {self._speeds[-1]:g} m/s, found {speed!r}")
        i = bisect_right(self._speeds, speed) - 1
        if speed == self._speeds[i]:
            return i, 0.0
        return i, (speed - self._speeds[i]) / (self._speeds[i + 1] - self._speeds[i])

    def clamp(self, speed: float) -> float:
        """Return the nearest speed (m/s) inside the table. Raises InputError if ``speed`` is not finite."""
        return min(max(finite_number("speed", speed), 0.0), self._speeds[-1])

    def at(self, values: Sequence[float], speed: float) -> float:
        """Return what is between ``values``, one a tabulated speed, at ``speed``. Raises as :meth:`place`."""
        i, weight = self.place(speed)
        return values[i] if weight == 0.0 else (1.0 - weight) * values[i] + weight * values[i + 1]

    def require_column_each(self, name: str, values: Sequence[float]) -> tuple[float, ...]:
        """Return ``values`` as floats. Raises InputError if one is not finite, or there is not one for each speed."""
        if len(values) != len(self._speeds):
            raise InputError(f"{name}: expected {len(self._speeds)} numbers, one a speed, found {len(values)}")
        return tuple(finite_number(f"{name}[{i}]", value) for i, value in enumerate(values))
