"""The largest ball about the origin that is attainable: what the bounds of [Ruth] Theorem 7.3 and Lemma 7.2 bound."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.attainable.boundary import FLAT, NOTHING, basis
from thrust_allocator.attainable.force_set import ForceSet
from thrust_allocator.attainable.margin import reach

_DIRECTIONS = 4000
_STARTS = 12
_MOST_ROUNDS = 2000


class Ball(NamedTuple):
    """Largest ball about the origin within a set."""

    radius: float  # unit of the set; 0 if the origin is on its boundary
    direction: FloatArray  # (3,), unit vector to where the ball touches the boundary; zeros with radius 0


def largest_ball(forces: ForceSet) -> Ball:
    """Return the largest ball about the origin within the attainable set.

    Its radius is the least of h(n) over unit vectors n, h being the support function. With plain units (N and N m as
    they stand) that is the norm of [Ruth] (7.78), (7.108); with ``forces.scaled(...)`` that of (7.76), (7.106).

    A zonotope touches its ball in the middle of a facet, so that the normals of all pairs of generators are tried. With
    discs, h is first taken in 4000 directions, 3 deg apart, and at normals where it has a kink; from the best a
    descent goes on: the normal of the boundary where it is pierced by n is a better n, until nothing changes.
    """
    none = Ball(0.0, np.zeros(3))
    span = np.where(forces.turns, forces.upper, forces.upper - forces.lower)
    columns = np.concatenate([forces.first * span[:, None], forces.second * span[:, None]])
    size = float(np.linalg.norm(columns))
    if size == 0.0 or basis(np.ascontiguousarray(columns))[0] < 3:
        return none
    lengths = np.linalg.norm(columns, axis=1)
    columns = columns[lengths > FLAT * lengths.max()]
    one, other = np.triu_indices(len(columns), 1)
    normals = np.cross(columns[one], columns[other])
    if forces.turns.any():
        normals = np.concatenate([normals, _sphere()])
    long = np.linalg.norm(normals, axis=1)
    # Parallel generators span no facet.
    normals = (normals / np.where(long > 0.0, long, 1.0)[:, None])[long > FLAT**2 * size**2]
    normals = np.concatenate([normals, -normals])
    heights = forces.support(normals)
    order = np.argsort(heights)
    best, normal = float(heights[order[0]]), normals[order[0]]
    if forces.turns.any() and best > NOTHING * size:
        for start in _apart(normals[order]):
            height, at = _descend(forces, start)
            if height < best:
                best, normal = height, at
    return Ball(best, normal) if best > NOTHING * size else none


def _sphere() -> FloatArray:
    """Return directions on half of the unit sphere, evenly spread along Fibonacci's spiral, shape (k, 3)."""
    index = np.arange(_DIRECTIONS // 2) + 0.5
    height = index / len(index)
    turn = np.pi * (1.0 + np.sqrt(5.0)) * index
    flat = np.sqrt(1.0 - height**2)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])


def _apart(normals: FloatArray) -> list[FloatArray]:
    """Return the first normals that are more than 20 deg from those before them: starts in different valleys."""
    chosen: list[FloatArray] = []
    for normal in normals:
        if all(float(normal @ other) < 0.94 for other in chosen):
            chosen.append(normal)
            if len(chosen) == _STARTS:
                break
    return chosen


def _descend(forces: ForceSet, normal: FloatArray) -> tuple[float, FloatArray]:
    """Return height and normal of a supporting plane that is nearest to the origin among its neighbours."""
    height = float(forces.support(normal))
    for _ in range(_MOST_ROUNDS):
        _, better = reach(forces, normal)
        better = better / np.linalg.norm(better)
        lower = float(forces.support(better))
        if not lower < height * (1.0 - 1e-14):
            break
        height, normal = lower, better
    return height, normal
