"""The nearest point of a convex polygon."""

from __future__ import annotations

from marine_model.compiled import compiled
from marine_model.guards import FloatArray


@compiled
def project(corners: FloatArray, count: int, x: float, y: float) -> tuple[float, float, int]:
    """Return the point of a convex polygon that is nearest to (x, y), and the face it lies on.

    Faces are numbered: 0 inside, 2 k + 1 for the edge from corner k to the next, 2 k + 2 for corner k.

    Parameters
    ----------
    corners
        Shape (count or more, 2), in the order of rising angle round the polygon. One corner is a point, two a segment,
        whose inside is its edge.
    count
        Number of corners, at least 1.
    x, y
        The point to project.
    """
    # By which side of every edge and corner the point lies on, not by distances: multipliers of a saturated step put it
    # some 1e9 N away, where the distances to two corners that are close are the same number.
    outside, ended, any_edge = False, False, False
    starts, face, clamped = False, 0, 0
    first = 0
    for k in range(count):
        following = k + 1 if k + 1 < count else 0
        x_k, y_k = corners[k, 0], corners[k, 1]
        edge_x, edge_y = corners[following, 0] - x_k, corners[following, 1] - y_k
        squared = edge_x * edge_x + edge_y * edge_y
        if squared == 0.0:
            continue
        to_x, to_y = x - x_k, y - y_k
        along = to_x * edge_x + to_y * edge_y
        # A segment is one edge, seen from either side.
        if count == 2 or edge_x * to_y - edge_y * to_x < 0.0:
            outside = True
            if 0.0 < along < squared:
                share = along / squared
                return x_k + share * edge_x, y_k + share * edge_y, 2 * k + 1
            clamped = 2 * k + 2 if along <= 0.0 else 2 * following + 2
        if not any_edge:
            any_edge, starts, first = True, along <= 0.0, k
        elif ended and along <= 0.0:
            face = 2 * k + 2
        ended = along >= squared
    if any_edge and not outside:
        return x, y, 0
    if not any_edge:
        face = 2
    elif ended and starts:
        face = 2 * first + 2
    elif face == 0:
        # Rounding has it beside every corner.
        face = clamped
    k = face // 2 - 1
    return corners[k, 0], corners[k, 1], face
