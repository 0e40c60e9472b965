"""Exact solution of a linear system over one interval: the matrix exponential applied to a vector.

x_dot = A x + f + g t with A, f, g constant. The Taylor series of the solution is summed until the rest is below
rounding, so the result does not depend on any step size. This is the method of Al-Mohy and Higham (*Computing the
action of the matrix exponential*, SIAM J. Sci. Comput. 33, 2011) with the number of terms fixed beforehand. It needs
one matrix-vector product a term, which at this size costs less than forming the exponential, and it takes the forcing
along for nothing.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from marine_model.guards import FloatArray

# An interval with a larger growth is cut into equal parts, still without approximation: the terms would swell before
# they fall and cost digits.
_LARGEST_GROWTH = 4.0
_NEGLIGIBLE = 2.0**-56  # of the state: an eighth of the rounding error of one addition
# Powers that bound the size of every term from number p (p - 1) on, p = 5: their Theorem 4.2.
_POWER = 5
_FEWEST_TERMS = _POWER * (_POWER - 1)


def growth_rate(matrices: FloatArray) -> float:
    """Return a (1/s) so that the j-th Taylor term over t is below (a t)^j / j! of the state for j >= 20.

    It is the larger of |A^5|^(1/5) and |A^6|^(1/6) of all ``matrices``, shape (k, n, n): for a matrix far from normal
    much less than its norm.
    """
    fifth = np.linalg.matrix_power(matrices, _POWER)
    sixth = fifth @ matrices
    largest_fifth = float(np.linalg.norm(fifth, 2, axis=(1, 2)).max())
    largest_sixth = float(np.linalg.norm(sixth, 2, axis=(1, 2)).max())
    return max(math.pow(largest_fifth, 1.0 / _POWER), math.pow(largest_sixth, 1.0 / (_POWER + 1)))


@lru_cache(maxsize=64)
def taylor_terms(growth: float) -> int:
    """Return how many terms after the first sum exp(``growth``), at most 4, to rounding."""
    count, term = 0, 1.0
    while count < _FEWEST_TERMS or term > _NEGLIGIBLE:
        count += 1
        term *= growth / count
    return count


class LinearFlow:
    """Carries states of shape (n,) over intervals of a family of linear systems.

    Parameters
    ----------
    order
        Number of states n.
    growth
        ``growth_rate`` (1/s) of all matrices that ``advance`` will be given.
    """

    def __init__(self, order: int, growth: float) -> None:
        self._growth = growth
        most = taylor_terms(_LARGEST_GROWTH)
        self._weights = np.array([1.0 / math.factorial(j) for j in range(most + 1)])
        self._terms = np.zeros((most + 1, order))
        self._rows = list(self._terms)
        self._scaled = np.zeros((order, order))

    def advance(
        self,
        matrix: FloatArray,
        state: FloatArray,
        force: FloatArray,
        ramp: FloatArray | None,
        duration: float,
    ) -> FloatArray:
        """Return the state, shape (n,), after ``duration`` (s) of x_dot = matrix x + force + ramp t.

        ``ramp`` None stands for zero. No argument is changed.
        """
        parts = max(1, math.ceil(self._growth * duration / _LARGEST_GROWTH))
        length = duration / parts
        count = taylor_terms(self._growth * length)
        rows, scaled = self._rows, self._scaled
        np.multiply(matrix, length, out=scaled)
        product = scaled.dot
        for part in range(parts):
            # Row j is length^j times the j-th derivative of the solution at the start of the part.
            rows[0][:] = state
            product(state, rows[1])
            rows[1] += force * length
            if ramp is None:
                product(rows[1], rows[2])
            else:
                rows[1] += ramp * (part * length * length)
                product(rows[1], rows[2])
                rows[2] += ramp * (length * length)
            for j in range(2, count):
                product(rows[j], rows[j + 1])
            state = self._weights[: count + 1].dot(self._terms[: count + 1])
        return state
