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
    if count == 1:
        return corners[0, 0], corners[0, 1], 2
    best = -1.0
    nearest_x, nearest_y, face = x, y, 0
    # A segment is one edge, seen from either side.
    for k in range(count if count > 2 else 1):
        following = k + 1 if k + 1 < count else 0
        x_k, y_k = corners[k, 0], corners[k, 1]
        edge_x, edge_y = corners[following, 0] - x_k, corners[following, 1] - y_k
        to_x, to_y = x - x_k, y - y_k
        squared = edge_x * edge_x + edge_y * edge_y
        if count > 2 and edge_x * to_y - edge_y * to_x >= 0.0:
            continue
        along = (to_x * edge_x + to_y * edge_y) / squared if squared > 0.0 else 0.0
        if along <= 0.0:
            at_x, at_y, on = x_k, y_k, 2 * k + 2
        elif along >= 1.0:
            at_x, at_y, on = corners[following, 0], corners[following, 1], 2 * following + 2
        else:
            at_x, at_y, on = x_k + along * edge_x, y_k + along * edge_y, 2 * k + 1
        distance = (x - at_x) ** 2 + (y - at_y) ** 2
        if best < 0.0 or distance < best:
            best = distance
            nearest_x, nearest_y, face = at_x, at_y, on
    return nearest_x, nearest_y, face
