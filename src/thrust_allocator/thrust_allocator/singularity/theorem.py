"""Minimum gain from singular values and from combinations of basis solutions: [Ruth] 7.3, 7.4, 7.7.1."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.singularity.exact import exact_gain
from thrust_allocator.singularity.jacobi import diagonalise, orthogonalise_rows
from thrust_allocator.singularity.minimum_norm import (
    LINE,
    PLANE,
    RAY,
    SECTOR,
    IntArray,
    constraint_rows,
    smallest_thrust,
    start_basis,
)

AUTO = 0
SVD = 1
THEOREM_7_1 = 2
THEOREM_7_2 = 3
LEMMA_7_1 = 4
EXACT = 5

# A gain below this share of the largest is rounding in the sines and cosines of B: reported as zero.
NO_GAIN = 1e-13


@compiled
def svd_gain(B: FloatArray, direction: FloatArray) -> tuple[float, float]:
    """Return the smallest and the largest singular value of B, shape (m, k); write the smallest's left vector.

    With fewer columns than rows the smallest is zero, and the vector is one that B cannot produce.
    """
    m = B.shape[0]
    work, left = B.copy(), np.empty((m, m))
    orthogonalise_rows(work, left)
    smallest, largest, chosen = math.inf, 0.0, 0
    for i in range(m):
        value = 0.0
        for j in range(B.shape[1]):
            value += work[i, j] * work[i, j]
        value = math.sqrt(value)
        largest = max(largest, value)
        if value < smallest:
            smallest, chosen = value, i
    # Both signs are as good. This one does not depend on the order of the columns.
    peak = 0
    for i in range(m):
        if abs(left[chosen, i]) > abs(left[chosen, peak]) + 1e-9:
            peak = i
    sign = -1.0 if left[chosen, peak] < 0.0 else 1.0
    for i in range(m):
        direction[i] = sign * left[chosen, i]
    return (smallest if smallest > NO_GAIN * largest else 0.0), largest


@compiled
def theorem_gain(B: FloatArray, kind: IntArray, edges: FloatArray, method: int, direction: FloatArray) -> float:
    """Return the bound of Theorem 7.1 or 7.2 or Lemma 7.1; write Theorem 7.5's direction (7.124).

    Zero where a direction cannot be produced, which is then what is written.
    """
    m, n = B.shape
    smallest, largest = svd_gain(B, direction)
    if smallest == 0.0:
        return 0.0
    rows = constraint_rows(n, kind, edges)
    room = m + len(rows) + 1
    basis, triangle = np.empty((room, n)), np.empty((room, room))
    start_basis(B, basis, triangle)
    solutions = np.empty((2 * m, n))  # row i: the shortest thrust for Gamma_i, [Ruth] (7.24)
    tau = np.empty(m)
    for i in range(2 * m):
        for j in range(m):
            tau[j] = 0.0
        tau[i % m] = 1.0 if i < m else -1.0
        if not smallest_thrust(m, rows, basis, triangle, tau, solutions[i]):
            direction[:] = tau
            return 0.0
    # Inner products of the solutions. Split in two, a bidirectional thruster contributes only where both use it the
    # same way round.
    inner = np.zeros((2 * m, 2 * m))
    column = 0
    for e in range(len(kind)):
        split = method == LEMMA_7_1 and (kind[e] == LINE or kind[e] == PLANE)
        for j in range(column, column + (1 if kind[e] <= RAY else 2)):
            for i in range(2 * m):
                for k in range(i, 2 * m):
                    product = solutions[i, j] * solutions[k, j]
                    if product > 0.0 or not split:
                        inner[i, k] += product
            column += 1
    # Theorem 7.2: the largest singular value of all Psi_k, from the eigenvalues of Psi_k' Psi_k.
    gram, vectors = np.empty((m, m)), np.empty((m, m))
    best = -1.0
    for k in range(1 << m):
        for i in range(m):
            a = i + m if (k >> i) & 1 else i
            for j in range(i, m):
                b = j + m if (k >> j) & 1 else j
                gram[i, j] = inner[min(a, b), max(a, b)]
                gram[j, i] = gram[i, j]
        diagonalise(gram, vectors, m)
        for i in range(m):
            if gram[i, i] > best * (1.0 + 1e-12):
                best = gram[i, i]
                # Of V_1 and -V_1, the one whose weights b are the less negative: Gamma_i are used with b >= 0.
                total = 0.0
                for j in range(m):
                    total += vectors[i, j]
                sign = -1.0 if total < 0.0 else 1.0
                for j in range(m):
                    side = -1.0 if (k >> j) & 1 else 1.0
                    direction[j] = sign * side * vectors[i, j]
    gain = 1.0 / math.sqrt(best)
    if method == THEOREM_7_1:
        total = 0.0
        for j in range(n):
            peak = 0.0
            for i in range(2 * m):
                peak = max(peak, abs(solutions[i, j]))
            total += peak * peak
        gain = 1.0 / math.sqrt(m * total)  # [Ruth] (7.29)
    return gain if gain > NO_GAIN * largest else 0.0


@compiled
def gain_of(B: FloatArray, kind: IntArray, edges: FloatArray, method: int, direction: FloatArray) -> float:
    """Return the minimum gain by ``method``, one of the numbers above; write its direction, shape (m,).

    AUTO is SVD without any constraint on directions, Lemma 7.1 otherwise. SVD takes every column as bidirectional.
    """
    if method == AUTO:
        method = SVD
        for e in range(len(kind)):
            if kind[e] == RAY or kind[e] == SECTOR:
                method = LEMMA_7_1
    if method == SVD:
        return svd_gain(B, direction)[0]
    if method == EXACT:
        smallest, largest = svd_gain(B, direction)
        if smallest == 0.0:
            return 0.0
        gain = exact_gain(B, kind, edges, direction)
        return gain if gain > NO_GAIN * largest else 0.0
    return theorem_gain(B, kind, edges, method, direction)
