"""Zonotopes of any number of axes: facets, how far they reach, volume."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.attainable.boundary import DIRECTION, FLAT, NOTHING


class Facets(NamedTuple):
    """A zonotope {generators' u, lower <= u <= upper} as half-spaces: normals n (k, m) with n'tau <= h, h (k,).

    ``outside`` (p, m) spans what is at right angles to a flat one; ``size`` is the sum of the lengths of its segments.
    """

    normals: FloatArray
    heights: FloatArray
    outside: FloatArray
    size: float


def facets(generators: FloatArray, lower: FloatArray, upper: FloatArray) -> Facets:
    """Return the half-spaces of a zonotope that holds the origin.

    A facet is spanned by m - 1 generators: the normals of all such subsets are tried. One whose generators are no facet
    or depend on each other bounds the set all the same, so that it does no harm.

    Parameters
    ----------
    generators
        Shape (k, m), rows and columns comparable in size (moments divided by a length).
    lower, upper
        Shape (k,), lower <= 0 <= upper.
    """
    segments = generators * (upper - lower)[:, None]
    lengths = np.linalg.norm(segments, axis=1)
    size, m = float(lengths.sum()), generators.shape[1]
    used = np.flatnonzero(lengths > 0.0)
    if not len(used):
        return Facets(np.zeros((0, m)), np.zeros(0), np.eye(m), 0.0)
    _, values, axes = np.linalg.svd(segments[used], full_matrices=True)
    rank = int((values > FLAT * values[0]).sum())
    span, outside = axes[:rank], axes[rank:]
    within = segments[used] @ span.T
    if rank == 1:
        normals = np.ones((1, 1))
    else:
        chosen = np.array(list(combinations(range(len(used)), rank - 1)))
        # The last right singular vector is at right angles to all of a subset.
        normals = np.linalg.svd(within[chosen] / lengths[used][chosen][..., None], full_matrices=True)[2][:, -1]
    normals = np.concatenate((normals, -normals)) @ span
    along = normals @ generators.T
    heights = np.maximum(lower * along, upper * along).sum(axis=1)
    return Facets(normals, heights, outside, size)


def zonotope_scale(of: Facets, direction: FloatArray) -> float:
    """Return the largest s >= 0 with ``s * direction`` in the zonotope; ``direction`` (m,) is not zero."""
    length = float(np.linalg.norm(direction))
    unit = direction / length
    if np.linalg.norm(of.outside @ unit) > DIRECTION or not len(of.normals):
        return 0.0
    along = of.normals @ unit
    towards = along > 0.0
    reach = float((of.heights[towards] / along[towards]).min())
    return reach / length if reach > NOTHING * of.size else 0.0


def zonotope_volume(generators: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
    """Return the volume: the boxes that m segments at a time span, summed. Arguments as in :func:`facets`."""
    segments = generators * (upper - lower)[:, None]
    chosen = list(combinations(range(len(segments)), generators.shape[1]))
    return float(np.abs(np.linalg.det(segments[chosen])).sum()) if chosen else 0.0
