"""Singular values and eigenvalues of matrices with very few rows, by Jacobi rotations.

LAPACK behind numpy spends several microseconds on a 3 x 7 matrix, most of it before it starts. One-sided rotations also
give small singular values to full relative accuracy, which the eigenvalues of B B' would not.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

_SWEEPS = 40  # a handful is enough; the limit only guards against NaN
_TINY = 1e-15  # rows this far from orthogonal, relative to their lengths, count as orthogonal: a few roundings


@compiled
def orthogonalise_rows(work: FloatArray, left: FloatArray) -> None:
    """Rotate the rows of ``work``, shape (m, k), in place until they are mutually orthogonal.

    ``left``, shape (m, m), receives the rotation: row i is the left singular vector that belongs to row i of ``work``,
    whose length is the singular value. Singular values come in no order.
    """
    m, k = work.shape
    total = 0.0
    for i in range(m):
        for j in range(m):
            left[i, j] = 1.0 if i == j else 0.0
        for j in range(k):
            total += work[i, j] * work[i, j]
    floor = 1e-32 * total
    for _ in range(_SWEEPS):
        rotated = False
        for p in range(m - 1):
            for q in range(p + 1, m):
                a, b, c = 0.0, 0.0, 0.0
                for j in range(k):
                    a += work[p, j] * work[p, j]
                    b += work[q, j] * work[q, j]
                    c += work[p, j] * work[q, j]
                if abs(c) <= _TINY * math.sqrt(a * b) or abs(c) <= floor:
                    continue
                rotated = True
                zeta = (b - a) / (2.0 * c)
                t = 1.0 / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                if zeta < 0.0:
                    t = -t
                cosine = 1.0 / math.sqrt(1.0 + t * t)
                sine = cosine * t
                for j in range(k):
                    x, y = work[p, j], work[q, j]
                    work[p, j] = cosine * x - sine * y
                    work[q, j] = sine * x + cosine * y
                for j in range(m):
                    x, y = left[p, j], left[q, j]
                    left[p, j] = cosine * x - sine * y
                    left[q, j] = sine * x + cosine * y
        if not rotated:
            return


@compiled
def diagonalise(matrix: FloatArray, vectors: FloatArray, m: int) -> None:
    """Turn the leading (m, m) block of a symmetric ``matrix`` into its eigenvalues, on the diagonal, in place.

    Row i of ``vectors``, at least (m, m), is the unit eigenvector of eigenvalue i. Eigenvalues come in no order.
    """
    total = 0.0
    for i in range(m):
        for j in range(m):
            vectors[i, j] = 1.0 if i == j else 0.0
            total += matrix[i, j] * matrix[i, j]
    floor = 1e-17 * math.sqrt(total)
    for _ in range(_SWEEPS):
        rotated = False
        for p in range(m - 1):
            for q in range(p + 1, m):
                c = matrix[p, q]
                if abs(c) <= floor:
                    continue
                rotated = True
                zeta = (matrix[q, q] - matrix[p, p]) / (2.0 * c)
                t = 1.0 / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                if zeta < 0.0:
                    t = -t
                cosine = 1.0 / math.sqrt(1.0 + t * t)
                sine = cosine * t
                matrix[p, p] -= t * c
                matrix[q, q] += t * c
                matrix[p, q] = 0.0
                matrix[q, p] = 0.0
                for j in range(m):
                    if j not in (p, q):
                        x, y = matrix[p, j], matrix[q, j]
                        matrix[p, j] = cosine * x - sine * y
                        matrix[q, j] = sine * x + cosine * y
                        matrix[j, p] = matrix[p, j]
                        matrix[j, q] = matrix[q, j]
                for j in range(m):
                    x, y = vectors[p, j], vectors[q, j]
                    vectors[p, j] = cosine * x - sine * y
                    vectors[q, j] = sine * x + cosine * y
        if not rotated:
            return
