"""A function of one number, tabulated for fast scalar look-up."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from marine_model.guards import FloatArray

# The maps of a propeller bend over about a tenth of their range: the straight pieces are within 1e-5 of them.
_POINTS = 2001


class ScalarMap:
    """Straight pieces between equidistant points; outside the range the value of its end.

    Parameters
    ----------
    function
        Vectorised.
    low, high
        Range, low below high.
    """

    def __init__(self, function: Callable[[FloatArray], FloatArray], low: float, high: float) -> None:
        self._low = low
        self._per_step = (_POINTS - 1) / (high - low)
        self._values: list[float] = function(np.linspace(low, high, _POINTS)).tolist()

    def __call__(self, x: float) -> float:
        """Return the value at ``x``."""
        place = (x - self._low) * self._per_step
        values = self._values
        if place <= 0.0:
            return values[0]
        if place >= _POINTS - 1:
            return values[-1]
        i = int(place)
        value = values[i]
        return value + (values[i + 1] - value) * (place - i)
