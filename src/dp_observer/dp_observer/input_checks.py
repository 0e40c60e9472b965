"""What may enter the observer."""

from __future__ import annotations

import math

from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector, positive_number

# Beyond these a number is a fault of its sender (no point of the Earth is farther off), and sums might overflow.
_LARGEST_POSITION = 1.0e8  # m
_LARGEST_FORCE = 1.0e12  # N
_LARGEST_STEP = 1.0e10  # s, more than any two ROS stamps are apart


def checked_position(value: ArrayLike) -> FloatArray:
    """Return a fix [north (m), east (m), heading (rad)], shape (3,). Raises InputError."""
    return _bounded("position", value, _LARGEST_POSITION)


def checked_tau(value: ArrayLike) -> FloatArray:
    """Return a generalized force (N, N, N m), shape (3,). Raises InputError."""
    return _bounded("tau", value, _LARGEST_FORCE)


def checked_place(value: ArrayLike) -> FloatArray:
    """Return a fix [depth (m), roll (rad), pitch (rad)], shape (3,). Raises InputError."""
    return _bounded("depth, roll and pitch", value, _LARGEST_POSITION)


def checked_vertical_tau(value: ArrayLike) -> FloatArray:
    """Return a force along heave (N) and moments about roll and pitch (N m), shape (3,). Raises InputError."""
    return _bounded("tau of heave, roll and pitch", value, _LARGEST_FORCE)


def checked_step(value: float) -> float:
    """Return a time step (s). Raises InputError."""
    dt = positive_number("dt", value)
    if dt > _LARGEST_STEP:
        raise InputError(f"dt: expected at most {_LARGEST_STEP:g} s, found {dt}")
    return dt


def _bounded(name: str, value: ArrayLike, largest: float) -> FloatArray:
    vector = finite_vector(name, value, 3)
    for number in vector.tolist():
        if math.fabs(number) > largest:
            raise InputError(f"{name}: expected numbers within {largest:g}, found {vector.tolist()}")
    return vector
