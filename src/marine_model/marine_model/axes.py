"""The six degrees of freedom of a vessel, in SNAME's order, and vectors over some of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from marine_model.errors import InputError
from marine_model.guards import FloatArray

Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]

AXES: Final[tuple[Axis, ...]] = ("surge", "sway", "heave", "roll", "pitch", "yaw")
# Of the generalized force along, or about, each axis.
FORCE_UNITS: Final = ("N", "N", "N", "N m", "N m", "N m")
# The degrees of freedom of a ship, and those that a submerged vehicle has besides.
HORIZONTAL: Final[tuple[Axis, ...]] = ("surge", "sway", "yaw")
VERTICAL: Final[tuple[Axis, ...]] = ("heave", "roll", "pitch")


def axis_indices(axes: Sequence[str]) -> NDArray[np.intp]:
    """Return where ``axes`` stand among all six, shape (m,).

    Raises
    ------
    InputError
        If one is not an axis.
    """
    for axis in axes:
        if axis not in AXES:
            raise InputError(f"axis: expected one of {', '.join(AXES)}, found '{axis}'")
    found: NDArray[np.intp] = np.array([AXES.index(axis) for axis in axes], dtype=np.intp)
    return found


def in_six(axes: Sequence[str], values: FloatArray) -> FloatArray:
    """Return a vector over all six degrees of freedom, shape (6,), from one over ``axes``; zero in the others."""
    vector = np.zeros(len(AXES))
    vector[axis_indices(axes)] = values
    return vector
