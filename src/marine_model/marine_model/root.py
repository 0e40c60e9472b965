"""Roots of many functions at once: the vectorised counterpart of ``scipy.optimize.brentq``."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from marine_model.guards import FloatArray

# Halvings that leave of a bracket what float64 cannot divide any more.
_HALVINGS = 60


def rising_root(function: Callable[[FloatArray], FloatArray], low: ArrayLike, high: ArrayLike) -> FloatArray:
    """Return where ``function`` passes from below zero to zero or above, element by element.

    Parameters
    ----------
    function
        Element-wise function of an array of the broadcast shape of ``low`` and ``high``.
    low, high
        Brackets. Where the function is above zero all over its bracket the root is ``low``, where it is below zero
        ``high``: a value held to its limits.
    """
    least, most = np.broadcast_arrays(np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64))
    left, right = least, most
    for _ in range(_HALVINGS):
        middle = 0.5 * (left + right)
        below = function(middle) < 0.0
        left, right = np.where(below, middle, left), np.where(below, right, middle)
    found = 0.5 * (left + right)
    # The ends themselves, to the last bit.
    found = np.where(function(least) >= 0.0, least, found)
    return np.asarray(np.where(function(most) <= 0.0, most, found))
