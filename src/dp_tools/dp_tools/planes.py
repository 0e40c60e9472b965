"""Six degrees of freedom as the horizontal plane and the rest, as runs, observer and controller keep them apart."""

from __future__ import annotations

import numpy as np

from marine_model.axes import HORIZONTAL, VERTICAL, axis_indices
from marine_model.frames import (
    attitude_to_quaternion,
    heading_to_quaternion,
    quaternion_to_attitude,
    quaternion_to_heading,
)
from marine_model.guards import FloatArray

PLANE = axis_indices(HORIZONTAL)
REST = axis_indices(VERTICAL)


def split(six: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return surge, sway, yaw and heave, roll, pitch, shape (3,) each; of a pose the same with places."""
    return six[PLANE], six[REST]


def joined(plane: FloatArray, rest: FloatArray) -> FloatArray:
    """Return the six numbers that :func:`split` takes apart."""
    six = np.empty(6)
    six[PLANE], six[REST] = plane, rest
    return six


def as_sent(position: FloatArray) -> FloatArray:
    """Return a position as it comes out of a message: its angles have been a quaternion. Shape (3,) or (6,)."""
    if len(position) == 3:
        north, east, heading = position.tolist()
        return np.array([north, east, quaternion_to_heading(*heading_to_quaternion(heading))])
    north, east, depth, roll, pitch, heading = position.tolist()
    return np.array([north, east, depth, *quaternion_to_attitude(*attitude_to_quaternion(roll, pitch, heading))])
