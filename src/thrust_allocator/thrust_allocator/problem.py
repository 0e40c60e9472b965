"""The allocation problem of one step, as an object: [Ruth] (4.20)-(4.42)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import cartesian_configuration, polar_configuration
from thrust_allocator.polygon import ROWS, rotating_rows

# Smallest weight of a slack in the slack form. At 1, first-order solvers stop up to 0.08 N from the optimum along
# directions that only W_u weighs; at 1e4, some do not converge.
_SLACK_FORM_WEIGHT = 100.0


# Slack (N) whose gradient is the smallest that others are compared with: without a demand nothing else would set a
# scale, and the rounding of 10 N alone is a gradient of 1e-8.
_SMALLEST_SLACK = 1e-3


def _numbers(array: FloatArray) -> memoryview[float]:
    """Return a writable view of all elements of ``array`` in a row."""
    return cast("memoryview[float]", memoryview(cast("Any", array.reshape(-1))))


@dataclass(frozen=True, slots=True)
class Weights:
    """What the problem needs to know of a vessel.

    Attributes
    ----------
    lever_x, lever_y
        Thruster positions, shape (n,), m.
    slack
        Diagonal of (gamma W_v)^2, shape (3,).
    thrust
        Diagonal of W_u^2, shape (n,).
    zero_region
        c_2.
    """

    lever_x: FloatArray
    lever_y: FloatArray
    slack: FloatArray
    thrust: FloatArray
    zero_region: float

    @classmethod
    def of(cls, vessel: Vessel) -> Weights:
        """Return the weights of ``vessel``."""
        gains = vessel.allocator
        return cls(
            vessel.lever_x,
            vessel.lever_y,
            (gains.slack_gain * np.array(gains.slack_weight)) ** 2,
            np.array(gains.thrust_weight) ** 2,
            gains.zero_region,
        )


@dataclass(frozen=True, slots=True)
class SlackForm:
    """The same problem with the slack as a variable: x = [z (m), s (3)], (4.20)-(4.22).

    Minimise x' P x / 2 subject to E x = tau, G x <= h and lower <= x <= upper. Its Hessian is diagonal, and ``scale``
    times that of the problem, which brings its weights from 1..1e8 to 1e-4..1e4: solvers that lose accuracy on the
    condensed form, or on large weights, are accurate on this one. Multipliers are ``scale`` times those of the problem.
    """

    P: FloatArray
    E: FloatArray
    tau: FloatArray
    G: FloatArray
    h: FloatArray
    lower: FloatArray
    upper: FloatArray
    scale: float


class AllocationProblem:
    """A convex quadratic program: minimise z' H z / 2 + f' z + c within bounds.

    The variables z are, in this order, the thrust (N) of every thruster allocated along a fixed direction and the
    pair T_x, T_y (N) of every rotating one. The slack s = tau - B z is eliminated, so that

        H = B' (gamma W_v)^2 B + W_u^2,   f = -B' (gamma W_v)^2 tau,   c = tau' (gamma W_v)^2 tau / 2

    and the cost (4.20) is twice the objective. Eliminating the fixed directions turns (4.28), (4.30) and (4.34) into
    bounds on a variable. Bounds come first, then the rows:

        b_lower[:k] <= z[:k] <= b_upper[:k],   b_lower[k:] <= A z <= b_upper[k:],   k = number of fixed thrusters

    All arrays are allocated once and overwritten from step to step: :meth:`copy` one to keep it.

    Parameters
    ----------
    weights
        Geometry and weights of the vessel.
    fixed, rotating
        Indices of the thrusters allocated in either form; a thruster in neither has its column set to zero.
    """

    __slots__ = (
        "A",
        "B",
        "H",
        "_a",
        "_gain",
        "_lower",
        "_upper",
        "b_lower",
        "b_upper",
        "f",
        "fixed",
        "gradient_floor",
        "rotating",
        "tau",
        "weights",
    )

    def __init__(self, weights: Weights, fixed: Sequence[int], rotating: Sequence[int]) -> None:
        self.weights = weights
        self.fixed = tuple(fixed)
        self.rotating = tuple(rotating)
        k, r = len(self.fixed), len(self.rotating)
        m = k + 2 * r
        self.tau = np.zeros(3)
        self.B = np.zeros((3, m))
        self.H = np.zeros((m, m))
        self.f = np.zeros(m)
        self.A = np.zeros((ROWS * r, m))
        self.b_lower = np.full(k + ROWS * r, -np.inf)
        self.b_upper = np.zeros(k + ROWS * r)
        self.gradient_floor = _SMALLEST_SLACK * float(weights.slack.min())
        self._gain = np.zeros((m, 3))
        # Single numbers go in through memory views, which costs half of what indexing an array does.
        self._a = _numbers(self.A)
        self._lower = _numbers(self.b_lower)
        self._upper = _numbers(self.b_upper)
        both = cartesian_configuration(weights.lever_x, weights.lever_y)
        n = len(weights.lever_x)
        for i, j in enumerate(self.rotating):
            self.B[:, k + 2 * i] = both[:, j]
            self.B[:, k + 2 * i + 1] = both[:, n + j]

    @property
    def variables(self) -> int:
        """Number of variables m."""
        return self.H.shape[0]

    @property
    def bounds(self) -> int:
        """Number k of variables with bounds of their own: the first ones."""
        return len(self.fixed)

    def point(self, azimuth: Sequence[float]) -> None:
        """Set the directions (rad) of the fixed thrusters, in their order here; to be called before use."""
        fixed, weights = list(self.fixed), self.weights
        k = len(fixed)
        self.B[:, :k] = polar_configuration(
            weights.lever_x[fixed], weights.lever_y[fixed], np.array(azimuth, dtype=np.float64)
        )
        np.multiply(self.B.T, weights.slack, out=self._gain)
        np.matmul(self._gain, self.B, out=self.H)
        self.H[np.diag_indices_from(self.H)] += self._variable_weights()

    def demand(self, tau: FloatArray) -> None:
        """Set the demanded generalized force, shape (3,), N, N, N m."""
        self.tau[:] = tau
        np.dot(self._gain, tau, out=self.f)
        np.negative(self.f, out=self.f)

    def limit_fixed(self, i: int, lower: float, upper: float) -> None:
        """Bound the thrust (N) of the ``i``-th fixed thruster, (4.30) and (4.34)."""
        self._lower[i] = lower
        self._upper[i] = upper

    def limit_rotating(
        self, i: int, azimuth: float, turn_low: float, turn_high: float, lower: float, upper: float
    ) -> None:
        """Write the rows of the ``i``-th rotating thruster; arguments as in :func:`polygon.rotating_rows`."""
        a, b_upper = self._a, self._upper
        k = len(self.fixed)
        m = k + 2 * len(self.rotating)
        at = ROWS * i * m + k + 2 * i
        row = k + ROWS * i
        for a_x, a_y, b in rotating_rows(azimuth, turn_low, turn_high, lower, upper, self.weights.zero_region):
            a[at] = a_x
            a[at + 1] = a_y
            b_upper[row] = b
            at += m
            row += 1

    def objective(self, z: FloatArray) -> float:
        """Return z' H z / 2 + f' z + c at ``z``, shape (m,); summed from squares, which keeps its precision."""
        slack = self.slack(z)
        return 0.5 * float(self.weights.slack @ slack**2 + self._variable_weights() @ z**2)

    def slack(self, z: FloatArray) -> FloatArray:
        """Return s = tau - B z, shape (3,)."""
        return self.tau - self.B @ z

    def slack_form(self) -> SlackForm:
        """Return the problem with the slack as a variable."""
        m, k = self.variables, self.bounds
        scale = _SLACK_FORM_WEIGHT / float(self.weights.slack.min())
        lower, upper = np.full(m + 3, -np.inf), np.full(m + 3, np.inf)
        lower[:k], upper[:k] = self.b_lower[:k], self.b_upper[:k]
        return SlackForm(
            P=np.diag(scale * np.concatenate([self._variable_weights(), self.weights.slack])),
            E=np.hstack([self.B, np.eye(3)]),
            tau=self.tau.copy(),
            G=np.hstack([self.A, np.zeros((len(self.A), 3))]),
            h=self.b_upper[k:].copy(),
            lower=lower,
            upper=upper,
            scale=scale,
        )

    def _variable_weights(self) -> FloatArray:
        """Return the diagonal of W_u^2 over the variables."""
        return self.weights.thrust[[*self.fixed, *(j for j in self.rotating for _ in range(2))]]

    def copy(self) -> AllocationProblem:
        """Return a problem of its own with the same numbers."""
        other = AllocationProblem(self.weights, self.fixed, self.rotating)
        for name in ("tau", "B", "H", "f", "A", "b_lower", "b_upper", "_gain"):
            getattr(other, name)[...] = getattr(self, name)
        return other
