"""A solver's answer, judged by the problem and not by the solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.problem import AllocationProblem


@dataclass(frozen=True, slots=True)
class Residuals:
    """How far an answer is from the conditions of Karush, Kuhn and Tucker.

    Attributes
    ----------
    violation
        Largest violation of a bound or row, N.
    stationarity
        Largest element of H z + f + A' lambda, over the largest term in that sum.
    complementarity
        Largest product of a multiplier and the distance (N) to the limit it belongs to, over the same term; NaN or
        infinite where a multiplier has the wrong sign.
    """

    violation: float
    stationarity: float
    complementarity: float

    def within(self, force: float, relative: float) -> bool:
        """Return whether all are small: ``force`` (N) for distances, ``relative`` for stationarity."""
        # A comparison with NaN is false, so that an answer that is not finite is refused here as well.
        return (
            self.violation <= force
            and self.stationarity <= relative
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
    k = problem.bounds
    values = np.concatenate((z[:k], problem.A @ z))
    upper_gap = problem.b_upper - values
    lower_gap = values - problem.b_lower
    violation = -min(upper_gap.min(), lower_gap.min())
    pull = multipliers[k:] @ problem.A
    pull[:k] += multipliers[:k]
    gradient = problem.H @ z + problem.f
    scale = max(1.0, np.abs(problem.f).max(), np.abs(pull).max())
    # Zero times an infinite distance is no product but an idle limit.
    gap = np.where(multipliers > 0.0, upper_gap, lower_gap)
    gap[multipliers == 0.0] = 0.0
    return Residuals(
        max(float(violation), 0.0),
        float(np.abs(gradient + pull).max() / scale),
        float(np.abs(multipliers * gap).max() / scale),
    )
