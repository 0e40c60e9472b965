"""Minimum gain from scaled thrust to scaled generalized force, for one or many scaled configuration matrices."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.singularity.minimum_norm import IntArray, checked_matrix
from thrust_allocator.singularity.scaling import mask
from thrust_allocator.singularity.theorem import (
    AUTO,
    EXACT,
    LEMMA_7_1,
    SVD,
    THEOREM_7_1,
    THEOREM_7_2,
    gain_of,
)

GainMethod = Literal["auto", "svd", "theorem_7_1", "theorem_7_2", "lemma_7_1", "exact"]
METHODS: dict[str, int] = {
    "auto": AUTO,
    "svd": SVD,
    "theorem_7_1": THEOREM_7_1,
    "theorem_7_2": THEOREM_7_2,
    "lemma_7_1": LEMMA_7_1,
    "exact": EXACT,
}


class MinimumGain(NamedTuple):
    """The smallest ratio of scaled generalized force to scaled thrust, and where it occurs.

    Attributes
    ----------
    gain
        At least 0; 0 where some direction cannot be produced.
    direction
        Unit scaled generalized force, shape (m,): the direction of smallest gain, [Ruth] (7.124), or one that cannot
        be produced.
    """

    gain: float
    direction: FloatArray


def method_number(method: str, rows: int, constrained: bool) -> int:
    """Return the number of a method of `minimum_gain`.

    Raises
    ------
    InputError
        If the name is unknown, 'svd' comes with constraints, or 'exact' with more than three rows.
    """
    if method not in METHODS:
        raise InputError(f"method: expected one of {', '.join(METHODS)}, found {method!r}")
    if method == "svd" and constrained:
        raise InputError(
            "method: expected another than 'svd', which takes every thruster as bidirectional, "
            "found 'svd' with unidirectional thrusters"
        )
    if method == "exact" and rows > 3:
        raise InputError(f"method: expected at most 3 rows for 'exact', found {rows}")
    return METHODS[method]


def minimum_gain(
    B_scaled: ArrayLike, unidirectional: ArrayLike | None = None, method: GainMethod = "auto"
) -> MinimumGain:
    """Return the minimum gain of fixed, or bidirectional freely rotating, thrusters: [Ruth] 7.3 to 7.5.1.

    Parameters
    ----------
    B_scaled
        Scaled thruster configuration matrix, shape (m, k), as from `scaled_configuration`.
    unidirectional
        Bool mask, shape (k,): columns that push only one way. None: all are bidirectional.
    method
        'svd': smallest singular value, all bidirectional, [Ruth] (7.17). 'theorem_7_1', 'theorem_7_2': lower bounds
        (7.29), (7.49). 'lemma_7_1': (7.49) with bidirectional columns split in two. 'exact': the true minimum of
        |tau| / |T| with T the shortest allowed thrust for tau; at most three rows. 'auto': 'svd' where all are
        bidirectional, 'lemma_7_1' otherwise.

    Returns
    -------
    The gain and its direction. They are ordered
    theorem_7_1 <= theorem_7_2, lemma_7_1 <= exact <= svd of the same matrix.

    Raises
    ------
    InputError
        If a shape or type is wrong, a number is not finite, or the method does not fit.
    """
    B = checked_matrix(B_scaled)
    m, k = B.shape
    kind = mask("unidirectional", unidirectional, k, default=False).astype(np.int64)
    number = method_number(method, m, bool(kind.any()))
    direction = np.empty(m)
    gain = gain_of(B, kind, np.zeros((k, 4)), number, direction)
    return MinimumGain(gain, direction)


def minimum_gains(
    B_scaled: ArrayLike, unidirectional: ArrayLike | None = None, method: GainMethod = "auto"
) -> tuple[FloatArray, FloatArray]:
    """Return what `minimum_gain` does for many matrices of one shape.

    Parameters
    ----------
    B_scaled
        Shape (count, m, k).
    unidirectional, method
        As in `minimum_gain`, the same for all.

    Returns
    -------
    Gains, shape (count,), and directions, shape (count, m).

    Raises
    ------
    InputError
        As `minimum_gain`.
    """
    B = np.ascontiguousarray(B_scaled, dtype=np.float64)
    if B.ndim != 3 or B.shape[1] < 1:
        raise InputError(f"B_scaled: expected shape (count, m, k), found {B.shape}")
    if not np.isfinite(B).all():
        raise InputError("B_scaled: expected finite numbers")
    count, m, k = B.shape
    kind = mask("unidirectional", unidirectional, k, default=False).astype(np.int64)
    number = method_number(method, m, bool(kind.any()))
    gains, directions = np.empty(count), np.empty((count, m))
    _gains(B, kind, number, gains, directions)
    return gains, directions


@compiled
def _gains(B: FloatArray, kind: IntArray, method: int, gains: FloatArray, directions: FloatArray) -> None:
    edges = np.zeros((len(kind), 4))
    for i in range(len(gains)):
        gains[i] = gain_of(B[i], kind, edges, method, directions[i])
