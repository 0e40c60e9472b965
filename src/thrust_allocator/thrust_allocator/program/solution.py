"""A solver's answer, judged by the problem and not by the solver."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt
from typing import NamedTuple

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.program.problem import AllocationProblem

# Beyond this, sums of squares overflow; no force is that large.
_LARGEST = 1e100


class Residuals(NamedTuple):
    """How far an answer is from the conditions of Karush, Kuhn and Tucker; NaN where the answer is not finite.

    Attributes
    ----------
    violation
        Largest violation of a bound or row, N.
    stationarity
        Length of H z + f + A' lambda, over the longest of f and A' lambda, or ``problem.gradient_floor``.
    dual_violation
        Largest multiplier of the wrong sign, over the same term.
    complementarity
        Length of the vector of products of a multiplier and the distance (N) to its limit, over the same term.
    """

    violation: float
    stationarity: float
    dual_violation: float
    complementarity: float

    def within(self, force: float, relative: float) -> bool:
        """Return whether all are small: ``force`` (N) for distances, ``relative`` for gradients."""
        # A comparison with NaN is false, so that an answer that is not finite is refused here as well.
        return (
            self.violation <= force
            and self.stationarity <= relative
            and self.dual_violation <= relative
            and self.complementarity <= force
        )


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver made of a problem.

    Attributes
    ----------
    z
        Variables, shape (m,), N.
    multipliers
        Of the bounds, then of the rows, shape (k + rows,): above 0 at an upper limit, below 0 at a lower one.
    iterations
        As the solver counts them; -1 where it does not say.
    message
        What the solver said: empty when it was content.
    residuals
        Judgement of ``z`` and ``multipliers``.
    """

    z: FloatArray
    multipliers: FloatArray
    iterations: int
    message: str
    residuals: Residuals


def judge(problem: AllocationProblem, z: FloatArray, multipliers: FloatArray) -> Residuals:
    """Return the residuals of ``z`` and ``multipliers`` for ``problem``; shapes as in :class:`Solution`."""
    # Summed in Python, where infinity and NaN pass without a warning.
    if not sum(map(abs, z.tolist())) + sum(map(abs, multipliers.tolist())) < _LARGEST:
        return Residuals(nan, nan, nan, nan)
    k = problem.bounds
    of_rows = multipliers[k:]
    gradient = problem.H.dot(z)
    gradient += problem.f
    pull = of_rows.dot(problem.A)
    pull[:k] += multipliers[:k]
    scale = max(problem.gradient_floor, sqrt(problem.f.dot(problem.f)), sqrt(pull.dot(pull)))
    gradient += pull
    violation = wrong_sign = products = 0.0
    if len(of_rows):
        gap = problem.b_upper[k:] - problem.A.dot(z)
        violation = -float(np.minimum.reduce(gap))
        # The rows have no lower limit, so that their multipliers have one sign.
        wrong_sign = -float(np.minimum.reduce(of_rows))
        gap *= of_rows
        products = gap.dot(gap)
    for i in range(k):
        value, multiplier = float(z[i]), float(multipliers[i])
        upper, lower = problem.b_upper[i] - value, value - problem.b_lower[i]
        violation = max(violation, -upper, -lower)
        products += (multiplier * (upper if multiplier > 0.0 else lower)) ** 2
    return Residuals(
        max(violation, 0.0),
        sqrt(gradient.dot(gradient)) / scale,
        max(wrong_sign, 0.0) / scale,
        sqrt(products) / scale,
    )
