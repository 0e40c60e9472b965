"""Outlines of the attainable set in a plane of two axes: what a section leaves of it, and its shadow."""

from __future__ import annotations

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.attainable.force_set import ForceSet
from thrust_allocator.attainable.margin import reach

AXES = ("surge", "sway", "yaw")


def section(forces: ForceSet, horizontal: str, vertical: str, points: int = 360) -> FloatArray:
    """Return boundary points of the section through the origin where the third axis is zero.

    Parameters
    ----------
    forces
        The set.
    horizontal, vertical
        Two of ``AXES``.
    points
        Number of points, in equal steps of angle with moments divided by the typical lever arm.

    Returns
    -------
    Shape (points, 2), in the units of the set, counter-clockwise.

    Raises
    ------
    InputError
        If an axis is unknown, or both are the same.
    """
    rays = _rays(forces, horizontal, vertical, points)
    reaches = np.array([reach(forces, ray)[0] for ray in rays])
    outline: FloatArray = (reaches[:, None] * rays)[:, _pair(horizontal, vertical)]
    return outline


def projection(forces: ForceSet, horizontal: str, vertical: str, points: int = 360) -> FloatArray:
    """Return boundary points of the projection on two axes, whatever the third is; parameters as in ``section``.

    Points are those furthest along each direction; a zonotope has corners, so that many fall together.
    """
    rays = _rays(forces, horizontal, vertical, points)
    balance = np.array([1.0, 1.0, forces.length])
    # A normal is to moments what a ray is, the other way round: its product with a point must keep its meaning.
    outline: FloatArray = forces.support_point(rays / balance**2)[:, _pair(horizontal, vertical)]
    return outline


def _pair(horizontal: str, vertical: str) -> list[int]:
    for name, axis in (("horizontal", horizontal), ("vertical", vertical)):
        if axis not in AXES:
            raise InputError(f"{name}: expected one of {', '.join(AXES)}, found {axis!r}")
    if horizontal == vertical:
        raise InputError(f"vertical: expected another axis than {horizontal}")
    return [AXES.index(horizontal), AXES.index(vertical)]


def _rays(forces: ForceSet, horizontal: str, vertical: str, points: int) -> FloatArray:
    one, other = _pair(horizontal, vertical)
    angles = 2.0 * np.pi * np.arange(points) / points
    rays = np.zeros((points, 3))
    rays[:, one], rays[:, other] = np.cos(angles), np.sin(angles)
    rays[:, 2] *= forces.length
    return rays
