"""The exact minimum gain of the minimum-norm allocation, where the thesis has lower bounds.

Let P be the projection on the cone of allowed thrusts. The shortest thrust for tau has the length
f(tau) = max { v' tau : |P(B' v)| <= 1 } (duality of norms), so that the largest f over unit tau is the largest |v| with
|P(B' v)| <= 1, and

    gain = min over |tau| = 1 of |tau| / f(tau) = min over |v| = 1 of |P(B' v)|,

attained at tau = v. |P(B' v)|^2 is once continuously differentiable, and quadratic, v' M v, in each cell that the
planes where P changes cut out of space. At a minimum over the sphere v is therefore an eigenvector of the M of its
cell. All cells are visited by walking along the arcs into which the planes cut each other's great circles. Where an
eigenvalue is multiple, the minimum is also attained on an arc or at its end, and these are candidates too. Every
candidate is a value of the function itself: the result is never below the minimum.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.singularity.jacobi import diagonalise
from thrust_allocator.singularity.minimum_norm import LINE, PLANE, RAY, IntArray

_FULL_TURN = 2.0 * math.pi
_SAME_PLANE = 1e-13  # rad; planes that rounding alone may have set apart


@compiled
def _squared_gain(B: FloatArray, kind: IntArray, edges: FloatArray, v: FloatArray) -> float:
    """Return |P(B' v)|^2."""
    total, j = 0.0, 0
    for e in range(len(kind)):
        x = B[0, j] * v[0] + B[1, j] * v[1] + B[2, j] * v[2]
        j += 1
        if kind[e] == LINE or (kind[e] == RAY and x > 0.0):
            total += x * x
        elif kind[e] >= PLANE:
            y = B[0, j] * v[0] + B[1, j] * v[1] + B[2, j] * v[2]
            j += 1
            inside = edges[e, 0] * y >= edges[e, 1] * x and edges[e, 3] * x >= edges[e, 2] * y
            if kind[e] == PLANE or inside:
                total += x * x + y * y
            else:
                along = max(0.0, edges[e, 0] * x + edges[e, 1] * y, edges[e, 2] * x + edges[e, 3] * y)
                total += along * along
    return total


@compiled
def _cell(B: FloatArray, kind: IntArray, edges: FloatArray, v: FloatArray, M: FloatArray) -> None:
    """Write the M of the cell in which ``v`` lies."""
    M[:] = 0.0
    j = 0
    for e in range(len(kind)):
        x = B[0, j] * v[0] + B[1, j] * v[1] + B[2, j] * v[2]
        j += 1
        if kind[e] <= RAY:
            if kind[e] == LINE or x > 0.0:
                for a in range(3):
                    for b in range(3):
                        M[a, b] += B[a, j - 1] * B[b, j - 1]
            continue
        y = B[0, j] * v[0] + B[1, j] * v[1] + B[2, j] * v[2]
        j += 1
        inside = edges[e, 0] * y >= edges[e, 1] * x and edges[e, 3] * x >= edges[e, 2] * y
        if kind[e] == PLANE or inside:
            for a in range(3):
                for b in range(3):
                    M[a, b] += B[a, j - 2] * B[b, j - 2] + B[a, j - 1] * B[b, j - 1]
            continue
        low = edges[e, 0] * x + edges[e, 1] * y
        high = edges[e, 2] * x + edges[e, 3] * y
        if max(low, high) > 0.0:
            first = 0 if low >= high else 2
            for a in range(3):
                for b in range(3):
                    left = edges[e, first] * B[a, j - 2] + edges[e, first + 1] * B[a, j - 1]
                    right = edges[e, first] * B[b, j - 2] + edges[e, first + 1] * B[b, j - 1]
                    M[a, b] += left * right


@compiled
def _walls(B: FloatArray, kind: IntArray, edges: FloatArray) -> FloatArray:
    """Return the unit normals of the planes in which P changes, shape (count, 3)."""
    count = 0
    for e in range(len(kind)):
        count += 1 if kind[e] == RAY else 4 if kind[e] > PLANE else 0
    walls = np.empty((count, 3))
    i, j = 0, 0
    for e in range(len(kind)):
        if kind[e] == RAY:
            walls[i] = B[:, j]
            i += 1
        elif kind[e] > PLANE:
            for first in (0, 2):
                for a in range(3):
                    # Where the projection leaves the sector, and where it leaves the edge.
                    walls[i, a] = -edges[e, first + 1] * B[a, j] + edges[e, first] * B[a, j + 1]
                    walls[i + 1, a] = edges[e, first] * B[a, j] + edges[e, first + 1] * B[a, j + 1]
                i += 2
        j += 2 if kind[e] >= PLANE else 1
    kept = 0
    for i in range(count):
        length = math.sqrt(walls[i, 0] ** 2 + walls[i, 1] ** 2 + walls[i, 2] ** 2)
        if length > 0.0:  # a thruster limited to no thrust has no plane
            for a in range(3):
                walls[kept, a] = walls[i, a] / length
            kept += 1
    return walls[:kept]


@compiled
def _offer(
    B: FloatArray, kind: IntArray, edges: FloatArray, v: FloatArray, best: float, direction: FloatArray
) -> float:
    """Return the smaller of ``best`` and the values at v and -v; write the direction if it is one of these."""
    for _ in range(2):
        value = _squared_gain(B, kind, edges, v)
        if value < best:
            best = value
            for a in range(3):
                direction[a] = v[a]
        for a in range(3):
            v[a] = -v[a]
    return best


@compiled
def _minimum_on_sphere(B: FloatArray, kind: IntArray, edges: FloatArray, direction: FloatArray) -> float:
    """Return the minimum of |P(B' v)|^2 over unit v in space; write where it is attained."""
    walls = _walls(B, kind, edges)
    count = len(walls)
    M, vectors = np.empty((3, 3)), np.empty((3, 3))
    v, u1, u2, across = np.zeros(3), np.empty(3), np.empty(3), np.empty(3)
    best = math.inf
    if count == 0:
        _cell(B, kind, edges, v, M)
        diagonalise(M, vectors, 3)
        for i in range(3):
            best = _offer(B, kind, edges, vectors[i], best, direction)
        return best
    angles = np.empty(2 * count)
    for w in range(count):
        normal = walls[w]
        # An orthonormal pair (u1, u2) in the plane.
        a = 0
        for i in range(1, 3):
            if abs(normal[i]) < abs(normal[a]):
                a = i
        b, d = (a + 1) % 3, (a + 2) % 3
        length = math.sqrt(normal[b] ** 2 + normal[d] ** 2)
        u1[a], u1[b], u1[d] = 0.0, -normal[d] / length, normal[b] / length
        for i in range(3):
            u2[i] = normal[(i + 1) % 3] * u1[(i + 2) % 3] - normal[(i + 2) % 3] * u1[(i + 1) % 3]
        found = 0
        for k in range(count):
            p = walls[k, 0] * u1[0] + walls[k, 1] * u1[1] + walls[k, 2] * u1[2]
            q = walls[k, 0] * u2[0] + walls[k, 1] * u2[1] + walls[k, 2] * u2[2]
            if k != w and p * p + q * q > _SAME_PLANE * _SAME_PLANE:
                angle = math.atan2(-p, q) % math.pi
                angles[found] = angle
                angles[found + 1] = angle + math.pi
                found += 2
        if found == 0:
            angles[0], angles[1] = 0.0, math.pi
            found = 2
        cuts = angles[:found]
        cuts.sort()
        for i in range(found):
            start = cuts[i]
            end = cuts[i + 1] if i + 1 < found else cuts[0] + _FULL_TURN
            width = end - start
            for a in range(3):
                v[a] = math.cos(start) * u1[a] + math.sin(start) * u2[a]
            best = _offer(B, kind, edges, v, best, direction)
            if width < _SAME_PLANE:
                continue
            middle = start + 0.5 * width
            c, s = math.cos(middle), math.sin(middle)
            tilt = 1.0  # into the cell on either side, and not out of it beyond: half way to the next plane
            for k in range(count):
                here, slope = 0.0, 0.0
                for a in range(3):
                    here += walls[k, a] * (c * u1[a] + s * u2[a])
                    slope += walls[k, a] * normal[a]
                if abs(here) > _SAME_PLANE and abs(here) < 2.0 * tilt * abs(slope):
                    tilt = 0.5 * abs(here / slope)
            for side in (-1.0, 1.0):
                for a in range(3):
                    across[a] = c * u1[a] + s * u2[a] + side * tilt * normal[a]
                _cell(B, kind, edges, across, M)
                # No smaller value in this cell if M - best I is positive definite. M knows its digits from its trace.
                level = best + 1e-14 * (M[0, 0] + M[1, 1] + M[2, 2])
                m11, m22, m33 = M[0, 0] - level, M[1, 1] - level, M[2, 2] - level
                minor = m11 * m22 - M[0, 1] * M[0, 1]
                if m11 > 0.0 and minor > 0.0:
                    m13, m23 = M[0, 2], M[1, 2]
                    if m33 * minor > m13 * (m13 * m22 - m23 * M[0, 1]) + m23 * (m23 * m11 - m13 * M[0, 1]):
                        continue
                # The stationary points on the arc first: M restricted to the plane.
                m11, m12, m22 = 0.0, 0.0, 0.0
                for a in range(3):
                    for b in range(3):
                        m11 += u1[a] * M[a, b] * u1[b]
                        m12 += u1[a] * M[a, b] * u2[b]
                        m22 += u2[a] * M[a, b] * u2[b]
                turn = 0.5 * math.atan2(2.0 * m12, m11 - m22)
                for a in range(3):
                    v[a] = -math.sin(turn) * u1[a] + math.cos(turn) * u2[a]
                best = _offer(B, kind, edges, v, best, direction)
                diagonalise(M, vectors, 3)
                for k in range(3):
                    best = _offer(B, kind, edges, vectors[k], best, direction)
    return best


@compiled
def exact_gain(B: FloatArray, kind: IntArray, edges: FloatArray, direction: FloatArray) -> float:
    """Return the minimum over unit tau of |tau| / |T|, T the shortest allowed thrust for tau; write that tau.

    Zero where ``direction`` cannot be produced. B has one to three rows.
    """
    m, n = B.shape
    if m == 3:
        return math.sqrt(_minimum_on_sphere(B, kind, edges, direction))
    # The missing directions get a thruster of their own that is stronger than all others.
    filler = 1.0
    for i in range(m):
        for j in range(n):
            filler += abs(B[i, j])
    whole = np.zeros((3, n + 3 - m))
    kinds = np.full(len(kind) + 3 - m, LINE)
    all_edges = np.zeros((len(kinds), 4))
    kinds[: len(kind)] = kind
    all_edges[: len(kind)] = edges
    for i in range(m):
        for j in range(n):
            whole[i, j] = B[i, j]
    for i in range(m, 3):
        whole[i, n + i - m] = filler
    found = np.empty(3)
    gain = math.sqrt(_minimum_on_sphere(whole, kinds, all_edges, found))
    for i in range(m):
        direction[i] = found[i]
    return gain
