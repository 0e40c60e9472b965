"""Convex sets of generalized forces as half-spaces about the origin: what is attainable, and what methods allow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Part of the largest corner within which a corner lies on a face: a few roundings of sums of products.
_ON_FACE = 1e-9
# Decimals of unit normals and relative heights that tell half-spaces apart; qhull cuts one face into many simplices.
_SAME_FACE = 9


@dataclass(frozen=True, eq=False)
class Polytope:
    """{x: normals x <= heights}, with the origin strictly inside.

    Attributes
    ----------
    normals
        Outward, shape (k, m), of any length.
    heights
        Shape (k,), above 0.
    """

    normals: FloatArray
    heights: FloatArray

    def __post_init__(self) -> None:
        if not (self.heights > 0.0).all():
            raise InputError("attainable set: expected the origin inside, found it on the boundary")

    def load(self, points: FloatArray) -> FloatArray:
        """Return how many times the set must grow to reach each point, shape (...), from points (..., m)."""
        loads: FloatArray = np.maximum((points @ (self.normals / self.heights[:, None]).T).max(axis=-1), 0.0)
        return loads

    def share_from(self, base: FloatArray, rest: FloatArray) -> float:
        """Return the largest s with ``base + s rest`` in the set; ``base`` (m,) is in it, ``rest`` (m,) is not zero."""
        along = self.normals @ rest
        room = self.heights - self.normals @ base
        towards = along > 0.0
        return float((room[towards] / along[towards]).min())

    def section(self, axes: Sequence[int]) -> Polytope:
        """Return what is left of the set where all other coordinates are zero, over ``axes``."""
        normals = self.normals[:, list(axes)]
        # A face at right angles to the others bounds nothing here.
        bounds = np.linalg.norm(normals, axis=1) > _ON_FACE * np.linalg.norm(self.normals, axis=1)
        return Polytope(normals[bounds], self.heights[bounds])

    def slice_corners(self, axes: Sequence[int], at: FloatArray) -> FloatArray | None:
        """Return the corners of the section where the other coordinates are those of ``at`` (m,), over ``axes``.

        Shape (k, 2), counter-clockwise, for two axes; None if nothing is left there.
        """
        other = np.where(np.isin(np.arange(len(at)), list(axes)), 0.0, at)
        normals, heights = self.normals[:, list(axes)], self.heights - self.normals @ other
        lengths = np.linalg.norm(normals, axis=1)
        # The centre of the largest ball within is a point that is surely inside.
        ball = linprog([0.0, 0.0, -1.0], np.column_stack([normals, lengths]), heights, bounds=[(None, None)] * 3)
        if not ball.success or ball.x[2] <= _ON_FACE * float(np.abs(self.vertices).max()):
            return None
        bounds = lengths > _ON_FACE * np.linalg.norm(self.normals, axis=1)
        spaces = np.column_stack([normals, -heights])[bounds]
        points = HalfspaceIntersection(spaces, ball.x[:2]).intersections
        corners: FloatArray = points[ConvexHull(points).vertices]
        return corners

    @cached_property
    def vertices(self) -> FloatArray:
        """Corners, shape (k, m); counter-clockwise with two axes."""
        m = self.normals.shape[1]
        if m == 1:
            bounds = self.heights / self.normals[:, 0]
            return np.array([[bounds[bounds < 0.0].max()], [bounds[bounds > 0.0].min()]])
        spaces = np.column_stack([self.normals, -self.heights])
        points = HalfspaceIntersection(spaces, np.zeros(m)).intersections
        corners: FloatArray = points[ConvexHull(points).vertices]
        return corners

    @cached_property
    def volume(self) -> float:
        """Length, area or volume, product of the units of the axes."""
        if self.normals.shape[1] == 1:
            return float(np.ptp(self.vertices))
        return float(ConvexHull(self.vertices).volume)

    def faces(self) -> list[FloatArray]:
        """Return the corners of every face, in order round it, shape (c, 3) each; three axes only."""
        unit = self.normals / np.linalg.norm(self.normals, axis=1)[:, None]
        offset = self.heights / np.linalg.norm(self.normals, axis=1)
        near = _ON_FACE * float(np.abs(self.vertices).max())
        found = []
        for normal, height in zip(unit, offset, strict=True):
            on = self.vertices[np.abs(self.vertices @ normal - height) <= near]
            if len(on) < 3:
                continue
            about = on - on.mean(axis=0)
            first = about[0] / np.linalg.norm(about[0])
            order = np.argsort(np.arctan2(about @ np.cross(normal, first), about @ first))
            found.append(on[order])
        return found


def zonotope(columns: FloatArray, lower: FloatArray, upper: FloatArray) -> Polytope:
    """Return {columns f: lower <= f <= upper}: all that thrusters along fixed directions can give.

    Corners are among the images of the 2^k corners of the box of thrusts, of which the convex hull is taken.

    Parameters
    ----------
    columns
        Generalized force per newton, shape (m, k).
    lower, upper
        Limits of thrust, shape (k,), N, lower < 0 < upper.
    """
    m = len(columns)
    corners = np.array(list(product(*zip(lower.tolist(), upper.tolist(), strict=True)))) @ columns.T
    if m == 1:
        return Polytope(np.array([[1.0], [-1.0]]), np.array([corners.max(), -corners.min()]))
    # Forces and moments of the same size, or qhull takes the one for rounding of the other.
    size = np.abs(corners).max(axis=0)
    equations = ConvexHull(corners / size).equations
    once = np.unique(np.round(equations, _SAME_FACE), axis=0, return_index=True)[1]
    return Polytope(equations[once, :-1] / size, -equations[once, -1])


def determinant_volume(columns: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
    """Return the volume of the zonotope: the sum of the boxes that every m of its segments span. Arguments as there."""
    segments = columns * (upper - lower)
    m, k = columns.shape
    return float(sum(abs(np.linalg.det(segments[:, list(chosen)])) for chosen in combinations(range(k), m)))


def octahedron(limits: FloatArray) -> Polytope:
    """Return {sum_i |x_i| / limits_i <= 1}, [Garus-F] (3.1); ``limits`` (m,) above 0."""
    signs = np.array(list(product((-1.0, 1.0), repeat=len(limits))))
    return Polytope(signs / limits, np.ones(len(signs)))


def pseudo_inverse_set(inverse: FloatArray, lower: FloatArray, upper: FloatArray) -> Polytope:
    """Return the demands whose thrusts ``inverse`` x are within limits; ``inverse`` (k, m), limits (k,), N."""
    return Polytope(np.concatenate([inverse, -inverse]), np.concatenate([upper, -lower]))


def inside(loads: FloatArray) -> NDArray[np.bool_]:
    """Return which loads count as within: 1, but for the rounding of sums of a few products."""
    within: NDArray[np.bool_] = loads <= 1.0 + _ON_FACE
    return within
