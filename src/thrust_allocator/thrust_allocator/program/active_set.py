"""The allocation problem solved with as many unknowns as controlled degrees of freedom, however many thrusters.

The problem of one step, [Ruth] (4.20)-(4.22), is

    minimise  s' Q s / 2 + sum_j w_j |u_j|^2 / 2   over s and u_j in C_j,   subject to   sum_j B_j u_j + s = tau

with Q = (gamma W_v)^2, w_j = W_u,j^2, u_j = (T_x, T_y) of thruster j and C_j its convex polygon: a segment for a fixed
thruster. With lambda the multipliers of the m equations, s = Q^-1 lambda, and each thruster answers on its own: u_j is
the nearest point of C_j to B_j' lambda / w_j.

If it is known on which face of its polygon (inside, edge, corner) every thruster lies, then u_j is linear in lambda,
and lambda solves m equations with the matrix Q^-1 + sum_j B_j D_j B_j' / w_j, D_j the projector onto the face. Two
searches for the faces use this. Newton's method on the dual lets all thrusters answer and takes the faces they choose;
from the multipliers of the step before it usually ends at once. Where thrusters saturate and many faces change, it may
go in circles: the dual has sharp ridges there, for Q is large. Then the primal active-set method follows, which goes
from one feasible point to a better one, changes one face at a time, and always ends (Nocedal and Wright, Numerical
Optimization, 16.5). Work per change of face is proportional to the number of thrusters.
"""

from __future__ import annotations

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.program.projection import project

IntArray = np.ndarray[tuple[int, ...], np.dtype[np.int64]]

# Newton's steps before the primal method takes over, and what that one may take a thruster.
_NEWTON_STEPS = 5
_CHANGES = 40
# Share of a step below which nothing has moved.
_NO_STEP = 1e-9
# Stationarity below which an answer needs no polish, and how often it gets one.
_POLISHED = 1e-16
_POLISHES = 2
# A multiplier counts as negative below this share of the largest generalized force it was summed from: rounding.
_ROUNDING = 1e-13


@compiled
def _tangent(corners: FloatArray, count: int, face: int) -> tuple[float, float, float]:
    """Return the projector onto the directions in which a point may move on a face: xx, xy, yy."""
    if face == 0:
        return 1.0, 0.0, 1.0
    if face % 2 == 0:
        return 0.0, 0.0, 0.0
    k = face // 2
    following = k + 1 if k + 1 < count else 0
    e_x, e_y = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
    squared = e_x * e_x + e_y * e_y
    return e_x * e_x / squared, e_x * e_y / squared, e_y * e_y / squared


@compiled
def _on_face(corners: FloatArray, count: int, face: int, x: float, y: float) -> tuple[float, float]:
    """Return the point of the affine hull of a face that is nearest to (x, y)."""
    if face == 0:
        return x, y
    k = (face - 1) // 2
    if face % 2 == 0:
        return corners[k, 0], corners[k, 1]
    following = k + 1 if k + 1 < count else 0
    e_x, e_y = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
    along = ((x - corners[k, 0]) * e_x + (y - corners[k, 1]) * e_y) / (e_x * e_x + e_y * e_y)
    return corners[k, 0] + along * e_x, corners[k, 1] + along * e_y


@compiled
def _along(corners: FloatArray, count: int, face: int, x: float, y: float) -> tuple[float, float]:
    """Return the part of a vector along a face; exactly along it, however large the part across was."""
    if face == 0:
        return x, y
    if face % 2 == 0:
        return 0.0, 0.0
    k = face // 2
    following = k + 1 if k + 1 < count else 0
    e_x, e_y = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
    share = (x * e_x + y * e_y) / (e_x * e_x + e_y * e_y)
    return share * e_x, share * e_y


@compiled
def _equations(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    compliance: FloatArray,
    tau: FloatArray,
    face: IntArray,
    matrix: FloatArray,
    right: FloatArray,
) -> None:
    """Write the m equations for the multipliers with every thruster on its face: lower triangle, right-hand side."""
    m = len(tau)
    for i in range(m):
        right[i] = tau[i]
        for k in range(i):
            matrix[i, k] = 0.0
        matrix[i, i] = compliance[i]
    for j in range(len(weight)):
        if count[j] == 0:
            continue
        on = face[j]
        d_xx, d_xy, d_yy = _tangent(corners[j], count[j], on)
        # The point of the face that is nearest to no thrust.
        x, y = _on_face(corners[j], count[j], on, 0.0, 0.0)
        d_xx /= weight[j]
        d_xy /= weight[j]
        d_yy /= weight[j]
        for i in range(m):
            b_x, b_y = B[j, i, 0], B[j, i, 1]
            right[i] -= b_x * x + b_y * y
            if on != 0 and on % 2 == 0:
                continue
            g_x, g_y = b_x * d_xx + b_y * d_xy, b_x * d_xy + b_y * d_yy
            for k in range(i + 1):
                matrix[i, k] += g_x * B[j, k, 0] + g_y * B[j, k, 1]


@compiled
def _cholesky(matrix: FloatArray) -> bool:
    """Replace the lower triangle by its factor; return whether it was positive definite."""
    for i in range(len(matrix)):
        for k in range(i + 1):
            value = matrix[i, k]
            for p in range(k):
                value -= matrix[i, p] * matrix[k, p]
            if i == k:
                if not value > 0.0:
                    return False
                matrix[i, i] = np.sqrt(value)
            else:
                matrix[i, k] = value / matrix[k, k]
    return True


@compiled
def _substitute(factor: FloatArray, x: FloatArray) -> None:
    """Solve with the factor of :func:`_cholesky`, in place."""
    m = len(x)
    for i in range(m):
        value = x[i]
        for p in range(i):
            value -= factor[i, p] * x[p]
        x[i] = value / factor[i, i]
    for i in range(m - 1, -1, -1):
        value = x[i]
        for p in range(i + 1, m):
            value -= factor[p, i] * x[p]
        x[i] = value / factor[i, i]


@compiled
def pull_of(B: FloatArray, j: int, multiplier: FloatArray) -> tuple[float, float]:
    """Return B_j' lambda."""
    x = y = 0.0
    for i in range(len(multiplier)):
        x += B[j, i, 0] * multiplier[i]
        y += B[j, i, 1] * multiplier[i]
    return x, y


@compiled
def respond(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    multiplier: FloatArray,
    force: FloatArray,
    face: IntArray,
) -> int:
    """Let every thruster answer the multipliers; return how many lie on another face than ``face`` said."""
    changed = 0
    for j in range(len(weight)):
        if count[j] == 0:
            continue
        x, y = pull_of(B, j, multiplier)
        u_x, u_y, on = project(corners[j], count[j], x / weight[j], y / weight[j])
        force[j, 0], force[j, 1] = u_x, u_y
        if on != face[j]:
            changed += 1
            face[j] = on
    return changed


@compiled
def _blocked(
    corners: FloatArray, count: int, face: int, x: float, y: float, d_x: float, d_y: float
) -> tuple[float, int]:
    """Return how far a thruster may go from (x, y) along d, 1 at most, and the face it then meets."""
    if face != 0 and face % 2 == 0:
        return 1.0, face
    length, met = 1.0, face
    if face == 0:
        for k in range(count):
            following = k + 1 if k + 1 < count else 0
            n_x, n_y = corners[following, 1] - corners[k, 1], corners[k, 0] - corners[following, 0]
            rate = n_x * d_x + n_y * d_y
            if rate > 0.0:
                gap = n_x * (corners[k, 0] - x) + n_y * (corners[k, 1] - y)
                if gap < length * rate:
                    length, met = max(gap, 0.0) / rate, 2 * k + 1
        return length, met
    k = face // 2
    following = k + 1 if k + 1 < count else 0
    e_x, e_y = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
    rate = e_x * d_x + e_y * d_y
    end = following if rate > 0.0 else k
    gap = e_x * (corners[end, 0] - x) + e_y * (corners[end, 1] - y)
    if rate != 0.0 and gap / rate < 1.0:
        return max(gap / rate, 0.0), 2 * end + 2
    return length, met


@compiled
def _edge(corners: FloatArray, count: int, k: int, step: int) -> tuple[int, float, float]:
    """Return the first edge from ``k`` on, going by ``step`` (1 or -1), that has a length, and its unit vector.

    -1 if no edge has one: a point.
    """
    for _ in range(count):
        following = k + 1 if k + 1 < count else 0
        e_x, e_y = corners[following, 0] - corners[k, 0], corners[following, 1] - corners[k, 1]
        length = np.sqrt(e_x * e_x + e_y * e_y)
        if length > 0.0:
            return k, e_x / length, e_y / length
        k += step
        if k < 0:
            k = count - 1
        elif k == count:
            k = 0
    return -1, 0.0, 0.0


@compiled
def _wrong_multiplier(corners: FloatArray, count: int, face: int, r_x: float, r_y: float) -> tuple[float, int]:
    """Return how fast the cost falls when a limit of a face is left, 0 if it does not, and the face without that limit.

    (r_x, r_y) is what the limits have to hold: minus the gradient. Its part along the way out of the face has the sign
    of the multiplier that would be wrong, with no division by the angle between two edges, which may be next to none.
    """
    if face == 0 or count == 1 or (count == 2 and face == 1):
        return 0.0, face
    k, e_x, e_y = _edge(corners, count, (face - 1) // 2, 1)
    if k < 0:
        return 0.0, face
    if face % 2 == 1:
        across = r_x * e_y - r_y * e_x
        return (across, 0) if across < 0.0 else (0.0, face)
    if count == 2:
        # Both ends of a segment are seen from corner k along its edge; outwards is away from the other end.
        inwards = r_x * e_x + r_y * e_y
        return (-inwards, 1) if inwards > 0.0 else (0.0, face)
    before, f_x, f_y = _edge(corners, count, (face - 2) // 2 - 1 if face > 2 else count - 1, -1)
    along, back = r_x * e_x + r_y * e_y, -(r_x * f_x + r_y * f_y)
    if along > 0.0 and along >= back:
        return -along, 2 * k + 1
    if back > 0.0:
        return -back, 2 * before + 1
    return 0.0, face


@compiled
def _improve(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    compliance: FloatArray,
    tau: FloatArray,
    multiplier: FloatArray,
    force: FloatArray,
    face: IntArray,
    matrix: FloatArray,
    right: FloatArray,
) -> int:
    """Go from a feasible ``force`` on ``face`` to the optimum; return the changes of face it took, -1 on failure."""
    m, n = len(tau), len(weight)
    # A limit that is met again at once, where it was left, had a multiplier of zero but for rounding. It is not left
    # again from the same point.
    stuck = np.zeros(n, dtype=np.bool_)
    released, left = -1, 0
    for change in range(_CHANGES * n):
        _equations(B, weight, corners, count, compliance, tau, face, matrix, right)
        if not _cholesky(matrix):
            return -1
        _substitute(matrix, right)
        length, first, met = 1.0, -1, 0
        for j in range(n):
            if count[j] == 0:
                continue
            x, y = pull_of(B, j, right)
            x, y = _on_face(corners[j], count[j], face[j], x / weight[j], y / weight[j])
            reach, on = _blocked(
                corners[j], count[j], face[j], force[j, 0], force[j, 1], x - force[j, 0], y - force[j, 1]
            )
            if reach < length:
                length, first, met = reach, j, on
        for j in range(n):
            if count[j] == 0:
                continue
            x, y = pull_of(B, j, right)
            x, y = _on_face(corners[j], count[j], face[j], x / weight[j], y / weight[j])
            force[j, 0] += length * (x - force[j, 0])
            force[j, 1] += length * (y - force[j, 1])
        if length > _NO_STEP and released >= 0:
            stuck[:] = False
        if first >= 0:
            if length <= _NO_STEP and first == released and met == left:
                stuck[first], released = True, -1
            face[first] = met
            force[first, 0], force[first, 1] = _on_face(
                corners[first], count[first], met, force[first, 0], force[first, 1]
            )
            continue
        size = 0.0
        for i in range(m):
            multiplier[i] = right[i]
            size = max(size, abs(right[i]))
        worst, first = -_ROUNDING * size, -1
        for j in range(n):
            if count[j] == 0 or stuck[j]:
                continue
            x, y = pull_of(B, j, multiplier)
            value, on = _wrong_multiplier(
                corners[j], count[j], face[j], x - weight[j] * force[j, 0], y - weight[j] * force[j, 1]
            )
            if value < worst:
                worst, first, met = value, j, on
        if first < 0:
            return change
        released, left = first, face[first]
        face[first] = met
    return -1


@compiled
def solve(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    compliance: FloatArray,
    tau: FloatArray,
    multiplier: FloatArray,
    force: FloatArray,
    face: IntArray,
    work: FloatArray,
) -> int:
    """Find the optimum from the multipliers of a problem like it; return the number of steps, -1 on failure.

    Parameters
    ----------
    B
        Generalized force of a newton along either axis, shape (n, m, 2).
    weight
        w_j, shape (n,), above 0.
    corners, count
        Polygons, shapes (n, c, 2) and (n,); a thruster with no corner takes no part.
    compliance
        Diagonal of Q^-1, shape (m,), above 0.
    tau
        Demanded generalized force, shape (m,).
    multiplier
        lambda to start from, shape (m,); overwritten with the answer.
    force, face
        Answers, shapes (n, 2), N, and (n,): 0 inside, 2 k + 1 on edge k, 2 k + 2 on corner k.
    work
        Shape (m, m + 1) or more; scratch.
    """
    m = len(tau)
    matrix, right = work[:, :m], work[:, m]
    for i in range(m):
        if not np.isfinite(multiplier[i]):
            multiplier[i] = 0.0
    for j in range(len(face)):
        force[j, 0] = force[j, 1] = 0.0
        face[j] = -1
    for step in range(_NEWTON_STEPS):
        if respond(B, weight, corners, count, multiplier if step == 0 else right, force, face) == 0:
            multiplier[:] = right
            return step
        _equations(B, weight, corners, count, compliance, tau, face, matrix, right)
        if not _cholesky(matrix):
            break
        _substitute(matrix, right)
    respond(B, weight, corners, count, multiplier, force, face)
    changes = _improve(B, weight, corners, count, compliance, tau, multiplier, force, face, matrix, right)
    return changes + _NEWTON_STEPS if changes >= 0 else -1


@compiled
def _gradient(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    compliance: FloatArray,
    tau: FloatArray,
    multiplier: FloatArray,
    force: FloatArray,
    face: IntArray,
    gradient: FloatArray,
    terms: FloatArray,
) -> float:
    """Set ``multiplier`` to Q s, s = tau - sum_j B_j u_j, and return the length of the gradient along the faces.

    ``gradient`` (n, 2) receives D_j (w_j u_j - B_j' Q s). The length is told as a share of that of |B|' Q t, t (m,) the
    sum of the sizes of the terms of s and of the corners that forces are reckoned from: where rounding comes from.
    ``terms`` receives t.
    """
    m = len(tau)
    for i in range(m):
        value, terms[i] = tau[i], abs(tau[i])
        for j in range(len(weight)):
            if count[j] == 0:
                continue
            x, y = force[j, 0], force[j, 1]
            value -= B[j, i, 0] * x + B[j, i, 1] * y
            if face[j] > 0:
                k = (face[j] - 1) // 2
                x, y = abs(x) + abs(corners[j, k, 0]), abs(y) + abs(corners[j, k, 1])
            terms[i] += abs(B[j, i, 0] * x) + abs(B[j, i, 1] * y)
        multiplier[i] = value / compliance[i]
    left = size = 0.0
    for j in range(len(weight)):
        gradient[j, 0] = gradient[j, 1] = 0.0
        if count[j] == 0:
            continue
        x, y = pull_of(B, j, multiplier)
        x, y = weight[j] * force[j, 0] - x, weight[j] * force[j, 1] - y
        gradient[j, 0], gradient[j, 1] = _along(corners[j], count[j], face[j], x, y)
        left += gradient[j, 0] ** 2 + gradient[j, 1] ** 2
        x = y = 0.0
        for i in range(m):
            x += abs(B[j, i, 0]) * terms[i] / compliance[i]
            y += abs(B[j, i, 1]) * terms[i] / compliance[i]
        size += x * x + y * y
    return float(np.sqrt(left / size)) if size > 0.0 else float(np.sqrt(left))


@compiled
def polish(
    B: FloatArray,
    weight: FloatArray,
    corners: FloatArray,
    count: IntArray,
    compliance: FloatArray,
    tau: FloatArray,
    multiplier: FloatArray,
    force: FloatArray,
    face: IntArray,
    work: FloatArray,
    gradient: FloatArray,
) -> float:
    """Take the rounding out of an answer of :func:`solve`, and return what is left: its stationarity, relative.

    In saturation the multipliers are some 1e8 times the thrusts they are to give, which are then good to 1e-8 only.
    One step of Newton's method on the primal, from the gradient as the thrusts themselves give it, repairs that.
    ``gradient`` is scratch, shape (n, 2); other arguments as there.
    """
    m = len(tau)
    matrix, right = work[:, :m], work[:, m]
    for _ in range(_POLISHES):
        left = _gradient(B, weight, corners, count, compliance, tau, multiplier, force, face, gradient, right)
        if left <= _POLISHED:
            return left
        _equations(B, weight, corners, count, compliance, tau, face, matrix, right)
        for i in range(m):
            right[i] = 0.0
            for j in range(len(weight)):
                right[i] += (B[j, i, 0] * gradient[j, 0] + B[j, i, 1] * gradient[j, 1]) / weight[j]
        if not _cholesky(matrix):
            return left
        _substitute(matrix, right)
        for j in range(len(weight)):
            if count[j] == 0:
                continue
            x, y = pull_of(B, j, right)
            x, y = _along(corners[j], count[j], face[j], x - gradient[j, 0], y - gradient[j, 1])
            force[j, 0], force[j, 1] = _on_face(
                corners[j], count[j], face[j], force[j, 0] + x / weight[j], force[j, 1] + y / weight[j]
            )
    return _gradient(B, weight, corners, count, compliance, tau, multiplier, force, face, gradient, right)
