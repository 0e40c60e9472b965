"""Shape and finiteness guards: the one place where numbers enter a core."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_model.errors import InputError

FloatArray = NDArray[np.float64]


def finite_vector(name: str, value: ArrayLike, length: int) -> FloatArray:
    """Return ``value`` as a float64 vector of shape (length,).

    Raises
    ------
    InputError
        If the shape differs or any element is NaN or infinite; the message names ``name``.
    """
    try:
        vector = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected {length} numbers, found {value!r}") from error
    if vector.shape != (length,):
        raise InputError(f"{name}: expected shape ({length},), found {vector.shape}")
    # A sum of finite numbers may overflow, one with a number that is not finite never is.
    if not math.isfinite(sum(vector.tolist())) and not np.isfinite(vector).all():
        raise InputError(f"{name}: expected finite numbers, found {vector.tolist()}")
    return vector


def finite_number(name: str, value: float) -> float:
    """Return ``value`` as a finite float.

    Raises
    ------
    InputError
        If it is not a number or not finite.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected a number, found {value!r}") from error
    if not math.isfinite(number):
        raise InputError(f"{name}: expected a finite number, found {number}")
    return number


def positive_number(name: str, value: float) -> float:
    """Return ``value`` as a finite float above zero, e.g. a time step.

    Raises
    ------
    InputError
        If it is not finite or not above zero.
    """
    number = finite_number(name, value)
    if number <= 0.0:
        raise InputError(f"{name}: expected a number above 0, found {number}")
    return number
