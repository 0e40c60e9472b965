"""The shortest thrust that gives a generalized force: [Ruth] (7.20)-(7.23), (7.101)-(7.103)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from thrust_allocator.singularity.scaling import mask

IntArray = NDArray[np.int64]

# What the thrust of one thruster is confined to. A LINE or RAY has one column of the configuration matrix; a PLANE or
# SECTOR has two, surge then sway.
LINE = 0  # fixed, bidirectional
RAY = 1  # fixed, unidirectional
PLANE = 2  # freely rotating
SECTOR = 3  # rotating within a window of at most 180 deg

# A constraint's normal this close to the span of the active ones counts as dependent on them: far above rounding.
_DEPENDENT = 1e-10
# Violation left in the answer, relative to its length: above the rounding of some ten operations.
_FEASIBLE = 1e-13


@compiled
def constraint_rows(columns: int, kind: IntArray, edges: FloatArray) -> FloatArray:
    """Return the unit rows A of A T >= 0, shape (q, columns): one for a ray, two for a sector.

    ``edges``, shape (len(kind), 4), holds the cosine and sine of the lower and the upper end of each sector's window.
    (The sources write A T <= 0, [Ruth] (7.100).)
    """
    q = 0
    for e in range(len(kind)):
        q += 1 if kind[e] == RAY else 2 if kind[e] == SECTOR else 0
    rows = np.zeros((q, columns))
    i, j = 0, 0
    for e in range(len(kind)):
        if kind[e] == RAY:
            rows[i, j] = 1.0
            i += 1
        elif kind[e] == SECTOR:
            rows[i, j] = -edges[e, 1]  # [Ruth] (7.98)
            rows[i, j + 1] = edges[e, 0]
            rows[i + 1, j] = edges[e, 3]  # [Ruth] (7.99)
            rows[i + 1, j + 1] = -edges[e, 2]
            i += 2
        j += 2 if kind[e] >= PLANE else 1
    return rows


@compiled
def _append(basis: FloatArray, triangle: FloatArray, size: int, row: FloatArray) -> float:
    """Orthonormalise ``row`` against the first ``size`` rows of ``basis``; return the length of what is left.

    The rest becomes row ``size`` of ``basis``, unit length unless it is negligible; its coordinates column ``size`` of
    ``triangle``.
    """
    n = len(row)
    for j in range(n):
        basis[size, j] = row[j]
    for k in range(size):
        triangle[k, size] = 0.0
    for _ in range(2):  # twice is enough for orthogonality to rounding
        for k in range(size):
            product = 0.0
            for j in range(n):
                product += basis[k, j] * basis[size, j]
            triangle[k, size] += product
            for j in range(n):
                basis[size, j] -= product * basis[k, j]
    length = 0.0
    for j in range(n):
        length += basis[size, j] * basis[size, j]
    length = math.sqrt(length)
    triangle[size, size] = length
    if length > 0.0:
        for j in range(n):
            basis[size, j] /= length
    return length


@compiled
def start_basis(B: FloatArray, basis: FloatArray, triangle: FloatArray) -> None:
    """Orthonormalise the rows of ``B`` into the first rows of ``basis``; B must have full row rank."""
    for i in range(B.shape[0]):
        _append(basis, triangle, i, B[i])


@compiled
def smallest_thrust(
    m: int, rows: FloatArray, basis: FloatArray, triangle: FloatArray, tau: FloatArray, thrust: FloatArray
) -> bool:
    """Write the shortest T with B T = tau and ``rows`` T >= 0 to ``thrust``; tell whether there is one.

    The dual active-set method of Goldfarb and Idnani with an identity Hessian: it starts from the pseudo-inverse and
    takes up violated constraints one by one, so it ends after finitely many steps with the exact answer. Without an
    answer, ``tau`` is overwritten by a unit vector v with v' B T <= 0 for every allowed T.

    Parameters
    ----------
    m
        Rows of B.
    rows
        Unit rows, shape (q, n).
    basis, triangle
        From `start_basis`, shapes (m + min(n, q) + 1, n) and square; rows from m on are work space.
    tau
        Shape (m,).
    thrust
        Shape (n,).
    """
    q, n = rows.shape
    active = np.empty(q + 1, dtype=np.int64)
    multiplier = np.zeros(q + 1)
    change = np.empty(m + q + 1)
    count = 0
    for j in range(n):
        thrust[j] = 0.0
    for i in range(m):
        value = tau[i]
        for k in range(i):
            value -= triangle[k, i] * change[k]
        change[i] = value / triangle[i, i]
        for j in range(n):
            thrust[j] += change[i] * basis[i, j]
    for _ in range(50 * (q + 1)):
        size = 0.0
        for j in range(n):
            size += thrust[j] * thrust[j]
        worst, chosen = -_FEASIBLE * math.sqrt(size), -1
        for i in range(q):
            product = 0.0
            for j in range(n):
                product += rows[i, j] * thrust[j]
            if product < worst:
                taken = False
                for k in range(count):
                    taken = taken or active[k] == i
                if not taken:
                    worst, chosen = product, i
        if chosen < 0:
            return True
        new_multiplier = 0.0
        violation = -worst
        while True:
            length = _append(basis, triangle, m + count, rows[chosen])
            for k in range(m + count - 1, -1, -1):
                value = triangle[k, m + count]
                for i in range(k + 1, m + count):
                    value -= triangle[k, i] * change[i]
                change[k] = value / triangle[k, k]
            step, leaving = math.inf, -1
            for k in range(count):
                if change[m + k] > 0.0 and multiplier[k] < step * change[m + k]:
                    step, leaving = multiplier[k] / change[m + k], k
            full = math.inf
            if length > _DEPENDENT:
                full = violation / (length * length)
            if leaving < 0 and full == math.inf:
                total = 0.0
                for i in range(m):
                    total += change[i] * change[i]
                total = math.sqrt(total)
                for i in range(m):
                    tau[i] = -change[i] / total
                return False
            taken_step = min(step, full)
            if full < math.inf:
                for j in range(n):
                    thrust[j] += taken_step * length * basis[m + count, j]
                violation -= taken_step * length * length
            for k in range(count):
                multiplier[k] -= taken_step * change[m + k]
            new_multiplier += taken_step
            if full <= step:
                active[count] = chosen
                multiplier[count] = new_multiplier
                count += 1
                break
            count -= 1
            for k in range(leaving, count):
                active[k] = active[k + 1]
                multiplier[k] = multiplier[k + 1]
            for k in range(leaving, count):
                _append(basis, triangle, m + k, rows[active[k]])
    return True  # not reached: each pass lengthens the thrust, so that no set of active constraints comes twice


@compiled
def solve_minimum_norm(B: FloatArray, kind: IntArray, edges: FloatArray, tau: FloatArray, thrust: FloatArray) -> bool:
    """One call of `smallest_thrust`, with B of full row rank."""
    m, n = B.shape
    rows = constraint_rows(n, kind, edges)
    room = m + len(rows) + 1
    basis, triangle = np.empty((room, n)), np.empty((room, room))
    start_basis(B, basis, triangle)
    return bool(smallest_thrust(m, rows, basis, triangle, tau.copy(), thrust))


def checked_matrix(B_scaled: ArrayLike) -> FloatArray:
    """Return ``B_scaled`` as a contiguous float64 matrix of at least one row.

    Raises
    ------
    InputError
        If it is not a finite matrix.
    """
    B = np.ascontiguousarray(B_scaled, dtype=np.float64)
    if B.ndim != 2 or B.shape[0] < 1:
        raise InputError(f"B_scaled: expected shape (m, k), found {B.shape}")
    if not np.isfinite(B).all():
        raise InputError(f"B_scaled: expected finite numbers, found {B.tolist()}")
    return B


def minimum_norm_thrust(
    B_scaled: ArrayLike, tau_scaled: ArrayLike, unidirectional: ArrayLike | None = None
) -> FloatArray | None:
    """Return the shortest scaled thrust, shape (k,), with B_scaled T = tau_scaled, [Ruth] (7.20)-(7.23).

    Parameters
    ----------
    B_scaled
        Scaled thruster configuration matrix, shape (m, k), of rank m.
    tau_scaled
        Scaled generalized force, shape (m,).
    unidirectional
        Bool mask, shape (k,): thrust of these is not below zero. None: all may be negative.

    Returns
    -------
    The thrust, or None where the allowed thrust cannot produce ``tau_scaled``.

    Raises
    ------
    InputError
        If a shape is wrong, a number is not finite, or B_scaled has not rank m.
    """
    B = checked_matrix(B_scaled)
    m, k = B.shape
    tau = finite_vector("tau_scaled", tau_scaled, m)
    rays = mask("unidirectional", unidirectional, k, default=False)
    rank = int(np.linalg.matrix_rank(B)) if k else 0
    if rank < m:
        raise InputError(f"B_scaled: expected rank {m}, found {rank}")
    thrust = np.empty(k)
    return thrust if solve_minimum_norm(B, rays.astype(np.int64), np.zeros((k, 4)), tau, thrust) else None
