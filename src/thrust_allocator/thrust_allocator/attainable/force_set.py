"""What each thruster can give: a segment at a given angle, a disc when it turns. Their sum is the attainable set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.axes import HORIZONTAL, axis_indices
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from thrust_allocator.singularity import scaling_of


@dataclass(frozen=True, slots=True)
class ForceSet:
    """Sum of one segment or disc a thruster, body frame.

    Thruster j gives ``u[0] first[j] + u[1] second[j]``. A thruster that turns has any u of length ``upper[j]`` or
    less (``lower`` is not used: reverse thrust adds nothing). One that does not has ``second[j]`` zero and ``u[0]``
    in [``lower[j]``, ``upper[j]``], 0 included.

    Attributes
    ----------
    first, second
        Generalized force (N, N, N m, or scaled) per newton, shape (n, 3).
    lower, upper
        Thrust limits, shape (n,), N.
    turns
        True where the thruster turns, shape (n,).
    length
        Typical lever arm of [Ruth] (7.2), m: what makes moments and forces comparable in tolerances.
    """

    first: FloatArray
    second: FloatArray
    lower: FloatArray
    upper: FloatArray
    turns: np.ndarray[tuple[int], np.dtype[np.bool_]]
    length: float

    def support(self, normals: FloatArray) -> FloatArray:
        """Return the largest value of ``normals @ tau`` over the set; normals (..., 3), result (...)."""
        along, across = normals @ self.first.T, normals @ self.second.T
        each = np.where(
            self.turns, self.upper * np.hypot(along, across), np.maximum(self.lower * along, self.upper * along)
        )
        result: FloatArray = each.sum(axis=-1)
        return result

    def support_point(self, normals: FloatArray) -> FloatArray:
        """Return a point of the set at which ``support`` is reached; normals (..., 3), result (..., 3)."""
        along, across = normals @ self.first.T, normals @ self.second.T
        size = np.hypot(along, across)
        with np.errstate(invalid="ignore", divide="ignore"):
            inverse = np.where(size > 0.0, self.upper / size, 0.0)
        one = np.where(self.turns, inverse * along, np.where(along > 0.0, self.upper, self.lower))
        two = np.where(self.turns, inverse * across, 0.0)
        result: FloatArray = one @ self.first + two @ self.second
        return result

    def scaled(self, thrust: float) -> ForceSet:
        """Return the set of non-dimensional generalized forces, [Ruth] (7.6), for a typical ``thrust`` in N."""
        factor = np.array([1.0, 1.0, 1.0 / self.length]) / thrust
        return ForceSet(self.first * factor, self.second * factor, self.lower, self.upper, self.turns, 1.0)


def force_set(
    vessel: Vessel,
    azimuth: ArrayLike | None = None,
    *,
    enabled: Sequence[bool] | None = None,
    thrust_limit_scale: ArrayLike | None = None,
    can_rotate: Sequence[bool] | None = None,
) -> ForceSet:
    """Return what the thrusters of a vessel can give in surge, sway and yaw, whatever else it controls.

    Parameters
    ----------
    vessel
        The vessel.
    azimuth
        Directions of all thrusters, shape (n,), rad: none turns. A tunnel keeps its own whatever stands here. None:
        every thruster named by ``can_rotate`` turns, the others keep the fixed directions of the vessel file.
    enabled
        n bools; False: the thruster is lost.
    thrust_limit_scale
        Fraction of both thrust limits that may be used, shape (n,), 0 to 1.
    can_rotate
        n bools, the vessel's own if left out. Only with ``azimuth`` None.

    Raises
    ------
    InputError
        If a shape is wrong, a number is not finite or out of range.
    """
    limits = limit_fraction(vessel, enabled, thrust_limit_scale)
    turns = np.zeros(len(limits), dtype=np.bool_)
    if azimuth is None:
        turns[:] = vessel.can_rotate if can_rotate is None else flags("can_rotate", can_rotate, len(limits))
        angles = vessel.fixed_direction
    else:
        given = finite_vector("azimuth", azimuth, len(limits))
        angles = np.where(vessel.can_rotate, given, vessel.fixed_direction)
    lower, upper = vessel.thrust_min * limits, vessel.thrust_max * limits
    # A disc is as wide as the stronger of both ways.
    upper = np.where(turns, np.maximum(upper, -lower), upper)
    columns = vessel.columns6[:, axis_indices(HORIZONTAL)]
    along = columns[:, :, 0] * np.cos(angles)[:, None] + columns[:, :, 1] * np.sin(angles)[:, None]
    first = np.where(turns[:, None], columns[:, :, 0], along)
    second = np.where(turns[:, None], columns[:, :, 1], 0.0)
    return ForceSet(
        np.ascontiguousarray(first),
        np.ascontiguousarray(second),
        lower,
        upper,
        turns,
        scaling_of(vessel).typical_arm,
    )


def limit_fraction(vessel: Vessel, enabled: Sequence[bool] | None, thrust_limit_scale: ArrayLike | None) -> FloatArray:
    """Return the fraction of the thrust limits that may be used, shape (n,); 0 where a thruster is lost.

    Raises
    ------
    InputError
        If a length is wrong or a fraction is outside of 0 to 1.
    """
    n = len(vessel.thrusters)
    fraction = np.ones(n)
    if thrust_limit_scale is not None:
        fraction = finite_vector("thrust_limit_scale", thrust_limit_scale, n)
        if (fraction < 0.0).any() or (fraction > 1.0).any():
            raise InputError(f"thrust_limit_scale: expected numbers from 0 to 1, found {fraction.tolist()}")
    if enabled is not None:
        fraction = fraction * flags("enabled", enabled, n)
    return fraction


def flags(name: str, value: Sequence[bool], length: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return a mask over thrusters, shape (length,).

    Raises
    ------
    InputError
        If there are not ``length`` of them, or one is not a bool.
    """
    mask = np.asarray(value)
    if mask.shape != (length,) or mask.dtype != np.bool_:
        raise InputError(f"{name}: expected {length} bools, one a thruster, found {value!r}")
    return mask
