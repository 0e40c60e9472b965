"""Volume of the attainable set."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.attainable.force_set import ForceSet

_LINE_POINTS = 4096
_PLANE_POINTS = 512


def volume(forces: ForceSet) -> float:
    """Return the volume of the attainable set, N^2 N m (1 if scaled).

    The volume of a sum of bodies is a sum over triples of them. Three segments contribute the box they span, which is
    all there is to a zonotope. A disc is a sum of segments in all directions; its
    integrals are taken by the trapezoidal rule over a period, good to 1e-6 of the result.
    """
    lengths = np.where(forces.turns, forces.upper, forces.upper - forces.lower)
    first, second = forces.first * lengths[:, None], forces.second * lengths[:, None]
    segments = [first[j] for j in range(len(lengths)) if not forces.turns[j] and lengths[j] > 0.0]
    discs = [(first[j], second[j]) for j in range(len(lengths)) if forces.turns[j] and lengths[j] > 0.0]
    total = 0.0
    total += sum(abs(float(np.linalg.det(np.array(triple)))) for triple in combinations(segments, 3))
    for disc in discs:
        normal = np.cross(*disc)
        total += np.pi * sum(abs(float(normal @ segment)) for segment in segments)
        total += np.pi * sum(2.0 * float(np.hypot(normal @ a, normal @ b)) for a, b in discs if a is not disc[0])
        for one, other in combinations(segments, 2):
            total += float(_width(disc, np.cross(one, other)))
    for one, other in combinations(discs, 2):
        for segment in segments:
            # The disc is the integral of segments of length 1/2 d angle all round, here twice those of half a turn.
            angles = np.pi * np.arange(_LINE_POINTS) / _LINE_POINTS
            total += np.pi * float(_width(other, np.cross(segment, _rim(one, angles))).mean())
    angles = np.pi * np.arange(_PLANE_POINTS) / _PLANE_POINTS
    for a, b, c in combinations(discs, 3):
        spans = np.cross(_rim(a, angles)[:, None, :], _rim(b, angles)[None, :, :])
        total += np.pi**2 * float(_width(c, spans).mean())
    return float(total)


def _rim(disc: tuple[FloatArray, FloatArray], angles: FloatArray) -> FloatArray:
    """Return points on the rim of a disc, shape (k, 3)."""
    rim: FloatArray = np.outer(np.cos(angles), disc[0]) + np.outer(np.sin(angles), disc[1])
    return rim


def _width(disc: tuple[FloatArray, FloatArray], normals: FloatArray) -> FloatArray:
    """Return the width of a disc along normals (..., 3), times their length."""
    width: FloatArray = 2.0 * np.hypot(normals @ disc[0], normals @ disc[1])
    return width
