"""The direction of minimum gain as an arrow in the surge-sway plane: [Ruth] 7.7.1."""

from __future__ import annotations

import math
from typing import NamedTuple

from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import finite_vector


class Projection(NamedTuple):
    """An arrow for the operator.

    Attributes
    ----------
    angle
        Direction in the surge-sway plane, rad in [-pi, pi], 0 ahead and positive to starboard.
    length
        Share of force in the vector: 1 without yaw moment, 0 for pure yaw.
    yaw_sign
        1.0 (red in [Ruth] Figure 7.14), -1.0 (blue), or 0.0.
    """

    angle: float
    length: float
    yaw_sign: float


def project(direction: ArrayLike) -> Projection:
    """Return the surge-sway projection of a scaled generalized force, shape (3,), [Ruth] after (7.127).

    The print has the length of tau_1 + tau_2, a sum of two numbers; the length of the vector (tau_1, tau_2) is meant:
    with the sum, surge and sway of opposite sign would cancel, and Figure 7.14's blue arrow have no length.

    Raises
    ------
    InputError
        If the shape is wrong, a number not finite, or all are 0.
    """
    vector = finite_vector("direction", direction, 3)
    x, y, n = vector.tolist()
    size = math.hypot(x, y, n)
    if size == 0.0:
        raise InputError("direction: expected a vector of some length, found zero")
    return Projection(math.atan2(y, x), math.hypot(x, y) / size, float((n > 0.0) - (n < 0.0)))
