"""The optimum to the last digits: daqp finds what is active, extended precision solves the equations of that.

Many problems of the same form at once. Every answer is checked by itself (limits, signs of multipliers, gradient); one
whose active limits turn out wrong is mended by exchanging limits, and told as not verified if that does not end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import daqp
import numpy as np
from numpy.typing import NDArray

from marine_model.guards import FloatArray
from thrust_allocator.program.problem import AllocationProblem

# 80 bits on x86-64: 64 of them for the digits.
Extended = NDArray[np.longdouble]

_REFINEMENTS = 3
_EXCHANGES = 12
# N, and relative to the largest multiplier: what an exact answer may show after rounding to 64 bits.
_FEASIBLE = 1e-12
_SIGN = 1e-12
_STATIONARY = 1e-9  # V, up to 1e8, times the rounding of 10 N to 64 bits is 1e-10 beside a gradient of 1


@dataclass(frozen=True, slots=True)
class Batch:
    """N problems of one form: minimise z' W z / 2 + s' V s / 2, s = tau - B z, lower <= C z <= upper.

    Attributes
    ----------
    W, V
        Weights of variables and of slacks, shapes (m,) and (3,).
    B, tau
        Shapes (N, 3, m), (N, 3).
    C, lower, upper
        Bounds as rows, then the rows: shapes (N, p, m), (N, p), (N, p).
    H, f
        The condensed form, shapes (N, m, m), (N, m), which daqp is given.
    bounds
        Number of rows that are bounds.
    """

    W: FloatArray
    V: FloatArray
    B: FloatArray
    tau: FloatArray
    C: FloatArray
    lower: FloatArray
    upper: FloatArray
    H: FloatArray
    f: FloatArray
    bounds: int

    @classmethod
    def of(cls, problems: Sequence[AllocationProblem]) -> Batch:
        """Return the batch of ``problems``.

        Raises
        ------
        ValueError
            If they are not of one form.
        """
        first = problems[0]
        if any((problem.fixed, problem.rotating) != (first.fixed, first.rotating) for problem in problems):
            raise ValueError("problems: expected one form, found several")
        k = len(first.fixed)
        m = first.B.shape[1]
        matrix = np.zeros((len(problems), len(first.b_upper), m))
        matrix[:, :k, :k] = np.eye(k)
        matrix[:, k:] = [problem.A for problem in problems]
        thrusters = [*first.fixed, *(j for j in first.rotating for _ in range(2))]
        return cls(
            W=first.weights.thrust[thrusters],
            V=first.weights.slack,
            B=np.array([problem.B for problem in problems]),
            tau=np.array([problem.tau for problem in problems]),
            C=matrix,
            lower=np.array([problem.b_lower for problem in problems]),
            upper=np.array([problem.b_upper for problem in problems]),
            H=np.array([problem.H for problem in problems]),
            f=np.array([problem.f for problem in problems]),
            bounds=k,
        )

    def cost(self, z: NDArray[Any]) -> Extended:
        """Return the cost (4.20) of ``z``, shape (N, m), in extended precision: shape (N,)."""
        wide = z.astype(np.longdouble)
        slack = self.tau.astype(np.longdouble) - np.einsum("nij,nj->ni", self.B.astype(np.longdouble), wide)
        return np.asarray((self.V * slack**2).sum(axis=1) + (self.W * wide**2).sum(axis=1))

    def violation(self, z: NDArray[Any]) -> FloatArray:
        """Return the largest violation of a limit by ``z``, N: shape (N,)."""
        wide = z.astype(np.longdouble)
        value = np.einsum("npm,nm->np", self.C.astype(np.longdouble), wide)
        excess = np.maximum(value - self.upper, self.lower - value)
        return np.asarray(np.maximum(excess.max(axis=1), 0.0), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Optimum:
    """Answers to a batch.

    Attributes
    ----------
    z
        Variables in extended precision, shape (N, m).
    cost
        (4.20), shape (N,).
    verified
        Limits hold, multipliers have their signs and the gradient is zero, shape (N,).
    """

    z: Extended
    cost: Extended
    verified: NDArray[np.bool_]


def optimum(batch: Batch) -> Optimum:
    """Return the optimum of every problem of ``batch``."""
    active = _active_by_daqp(batch)
    z, multipliers = _solve(batch, active, np.arange(len(active)))
    verified = np.zeros(len(active), dtype=np.bool_)
    for _ in range(_EXCHANGES):
        wrong = np.flatnonzero(~verified)
        value = np.einsum("npm,nm->np", batch.C[wrong].astype(np.longdouble), z[wrong])
        excess = np.maximum(value - batch.upper[wrong], batch.lower[wrong] - value)
        pull = multipliers[wrong] * active[wrong]
        scale = np.maximum(np.abs(multipliers[wrong]).max(axis=1), 1.0)
        verified[wrong] = (
            (excess.max(axis=1) <= _FEASIBLE)
            & (pull.min(axis=1) >= -_SIGN * scale)
            & (_gradient(batch, wrong, z[wrong], multipliers[wrong]) <= _STATIONARY)
        )
        excess[active[wrong] != 0] = 0.0
        for place, i in enumerate(wrong.tolist()):
            if verified[i]:
                continue
            if pull[place].min() < -_SIGN * scale[place]:
                active[i, int(pull[place].argmin())] = 0
            else:
                row = int(excess[place].argmax())
                active[i, row] = 1 if value[place, row] > batch.upper[i, row] else -1
        wrong = np.flatnonzero(~verified)
        if not len(wrong):
            break
        z[wrong], multipliers[wrong] = _solve(batch, active, wrong)
    return Optimum(z, batch.cost(z), verified)


def optima(problems: Sequence[AllocationProblem]) -> list[FloatArray]:
    """Return the variables of the optimum of every problem, rounded; the forms may differ.

    Raises
    ------
    ValueError
        If one could not be verified.
    """
    groups: dict[tuple[tuple[int, ...], tuple[int, ...], int], list[int]] = {}
    for i, problem in enumerate(problems):
        groups.setdefault((problem.fixed, problem.rotating, len(problem.A)), []).append(i)
    found: list[FloatArray] = [np.zeros(0)] * len(problems)
    for places in groups.values():
        answer = optimum(Batch.of([problems[i] for i in places]))
        if not answer.verified.all():
            raise ValueError(f"reference: {int((~answer.verified).sum())} of {len(places)} problems not solved")
        for i, z in zip(places, answer.z, strict=True):
            found[i] = z.astype(np.float64)
    return found


def _gradient(batch: Batch, of: NDArray[np.intp], z: Extended, multipliers: Extended) -> Extended:
    """Return the longest component of W z - B' V s + C' multipliers over that of B' V s or 1, shape (K,)."""
    B, C = batch.B[of].astype(np.longdouble), batch.C[of].astype(np.longdouble)
    slack = batch.tau[of] - np.einsum("nij,nj->ni", B, z)
    pull = np.einsum("nij,ni->nj", B, batch.V * slack)
    gradient = batch.W * z - pull + np.einsum("npm,np->nm", C, multipliers)
    return np.asarray(np.abs(gradient).max(axis=1) / np.maximum(np.abs(pull).max(axis=1), 1.0))


def _active_by_daqp(batch: Batch) -> NDArray[np.int8]:
    """Return 1, -1, 0 for limits active above, below, not: shape (N, p)."""
    active = np.zeros(batch.upper.shape, dtype=np.int8)
    rows = batch.C[:, batch.bounds :]
    for i in range(len(active)):
        _, _, flag, information = daqp.solve(
            batch.H[i], batch.f[i], np.ascontiguousarray(rows[i]), batch.upper[i], batch.lower[i], primal_tol=1e-10
        )
        if flag == 1:  # otherwise from nothing, by exchanging
            active[i] = np.sign(information["lam"])
    return active


def _solve(batch: Batch, active: NDArray[np.int8], of: NDArray[np.intp]) -> tuple[Extended, Extended]:
    """Return variables and multipliers with the active limits as equations: shapes (K, m), (K, p), K = len(of).

    Unknowns are z, the multiplier of B z + s = tau (which is V s), and those of the limits; a limit that is not active
    has the equation "multiplier = 0". Solved with 53 bits, refined with 64.
    """
    m, p = len(batch.W), active.shape[1]
    count = len(of)
    on = active[of] != 0
    matrix = np.zeros((count, m + 3 + p, m + 3 + p))
    right = np.zeros((count, m + 3 + p))
    diagonal = np.arange(m)
    matrix[:, diagonal, diagonal] = batch.W
    B, C = batch.B[of], batch.C[of] * on[:, :, None]
    matrix[:, :m, m : m + 3] = -B.transpose(0, 2, 1)
    matrix[:, m : m + 3, :m] = B
    slack = np.arange(m, m + 3)
    matrix[:, slack, slack] = 1.0 / batch.V
    right[:, m : m + 3] = batch.tau[of]
    matrix[:, :m, m + 3 :] = C.transpose(0, 2, 1)
    matrix[:, m + 3 :, :m] = C
    limit = np.arange(m + 3, m + 3 + p)
    matrix[:, limit, limit] = ~on
    right[:, m + 3 :] = np.where(active[of] > 0, batch.upper[of], np.where(active[of] < 0, batch.lower[of], 0.0))
    inverse = _inverse(matrix)
    # 1 / V is rounded in the matrix, and not in what the residual is taken with.
    wide = matrix.astype(np.longdouble)
    wide[:, slack, slack] = 1.0 / batch.V.astype(np.longdouble)
    target = right.astype(np.longdouble)
    x = np.zeros_like(target)
    for _ in range(1 + _REFINEMENTS):
        residual = target - np.einsum("nij,nj->ni", wide, x)
        x += np.einsum("nij,nj->ni", inverse, residual.astype(np.float64))
    return x[:, :m], x[:, m + 3 :]


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return the inverse of each; the pseudo-inverse where there is none, which its check will refuse."""
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
