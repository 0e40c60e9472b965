"""Least thrusts that give a demand, without a thought of limits: [Garus-F] (2.3), [Garus-A] (6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from marine_model.guards import FloatArray

# Singular values below this part of the largest count as zero. Directions are written down to 12 digits, and a step of
# an azimuth thruster away from a singular direction is 1e-3 rad or more.
RANK_TOLERANCE = 1e-9


def pseudo_inverse(
    configuration: FloatArray, used: NDArray[np.bool_], axis_weight: FloatArray | None = None
) -> FloatArray:
    """Return B* with f = B* tau, shape (n, m): the Moore-Penrose inverse of the columns in use, other rows zero.

    It is B' (B B')^-1 of (2.3) while that exists. When thrusters are lost, or all point the same way, B B' is singular;
    f is then the shortest of the thrusts that come nearest to the demand.

    Parameters
    ----------
    configuration
        B, generalized force per newton of every thruster, shape (m, n).
    used
        Which thrusters are not lost, shape (n,).
    axis_weight
        What a miss in every axis weighs, shape (m,), above 0, in 1/N or 1/(N m) up to a common factor: it makes forces
        and moments comparable. 1 if left out. Without a miss it has no say.
    """
    weight = np.ones(len(configuration)) if axis_weight is None else axis_weight
    inverse = np.zeros((configuration.shape[1], len(configuration)))
    if used.any():
        found = np.linalg.pinv(weight[:, None] * configuration[:, used], rcond=RANK_TOLERANCE)
        inverse[used] = found * weight
    return inverse


def share_within(base: FloatArray, rest: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
    """Return the largest k, 0 to 1, with lower <= base + k rest <= upper; 0 where ``base`` itself is outside.

    Parameters
    ----------
    base, rest
        Thrusts, shape (n,), N.
    lower, upper
        Limits, shape (n,), N, lower <= 0 <= upper.
    """
    room = np.where(rest > 0.0, upper - base, base - lower)
    moves = rest != 0.0
    if not moves.any():
        return 1.0
    return float(np.clip((room[moves] / np.abs(rest[moves])).min(), 0.0, 1.0))
