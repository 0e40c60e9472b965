"""The allocation problem of one step, as an object: [Ruth] (4.20)-(4.42)."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import LOST, ROTATING
from thrust_allocator.plan.polygon import CORNERS, rotating_rows
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.step import set_polygons

# Smallest weight of a slack in the slack form. At 1, first-order solvers stop up to 0.08 N from the optimum along
# directions that only W_u weighs; at 1e4, some do not converge.
_SLACK_FORM_WEIGHT = 100.0


# Slack (N) whose gradient is the smallest that others are compared with: without a demand nothing else would set a
# scale, and the rounding of 10 N alone is a gradient of 1e-8.
_SMALLEST_SLACK = 1e-3


@dataclass(frozen=True, slots=True)
class Coupling:
    """Limits that several thrusters share, as a power bus does: sum_j a_j' u_j <= b, one row each.

    Attributes
    ----------
    a
        Shape (k, n, 2), over the Cartesian thrusts u_j = (T_x, T_y).
    b
        Shape (k,).
    """

    a: FloatArray
    b: FloatArray


@dataclass(frozen=True, slots=True)
class Weights:
    """What the problem needs to know of a vessel.

    Attributes
    ----------
    columns
        Generalized force of a newton along n_1 and n_2 of every thruster, shape (n, m, 2): (4.24) by thruster.
    slack
        Diagonal of (gamma W_v)^2, shape (m,), one for every degree of freedom of the vessel.
    thrust
        Diagonal of W_u^2, shape (n,).
    zero_region
        c_2.
    """

    columns: FloatArray
    slack: FloatArray
    thrust: FloatArray
    zero_region: float

    @classmethod
    def of(cls, vessel: Vessel) -> Weights:
        """Return the weights of ``vessel``."""
        gains = vessel.allocator
        return cls(
            # A copy: compiled routines take read-only arrays for another type and would be compiled twice.
            vessel.columns.copy(),
            (gains.slack_gain * np.array(gains.slack_weight)) ** 2,
            np.array(gains.thrust_weight) ** 2,
            gains.zero_region,
        )


@dataclass(frozen=True, slots=True)
class SlackForm:
    """The same problem with the slack as a variable: x = [z, s], (4.20)-(4.22).

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
    bounds on a variable. Bounds come first, then the rows of every rotating thruster, five unless said otherwise, then
    shared limits:

        b_lower[:k] <= z[:k] <= b_upper[:k],   b_lower[k:] <= A z <= b_upper[k:],   k = number of fixed thrusters

    Parameters
    ----------
    weights
        Geometry and weights of the vessel.
    plans
        What every thruster may do in this step, shape (n, 6), see :class:`phase.Plan`. A lost one has no variable.
    tau
        Demanded generalized force over the degrees of freedom, shape (m,), N or N m.
    coupling
        Limits shared by several thrusters, if any.
    polygons
        Corners and their number, shapes (n, c, 2) and (n,), for rotating thrusters whose polygon is another one than
        that of their plan. They then have a row for every edge.
    """

    def __init__(
        self,
        weights: Weights,
        plans: FloatArray,
        tau: FloatArray,
        coupling: Coupling | None = None,
        polygons: tuple[FloatArray, IntArray] | None = None,
    ) -> None:
        self.weights = weights
        self.plans = plans.copy()
        self.tau = tau.copy()
        self.coupling = coupling
        phases = plans[:, 0]
        fixed = np.flatnonzero((phases != LOST) & (phases != ROTATING))
        rotating = np.flatnonzero(phases == ROTATING)
        self.fixed: tuple[int, ...] = tuple(fixed.tolist())
        self.rotating: tuple[int, ...] = tuple(rotating.tolist())
        k, r = len(fixed), len(rotating)
        m = k + 2 * r
        columns = weights.columns
        self.B = np.empty((len(self.tau), m))
        directions = np.column_stack((np.cos(plans[fixed, 3]), np.sin(plans[fixed, 3])))
        self.B[:, :k] = (columns[fixed] * directions[:, None, :]).sum(axis=2).T
        for i, j in enumerate(rotating):
            self.B[:, k + 2 * i : k + 2 * i + 2] = columns[j]
        gain = self.B.T * weights.slack
        self.H = gain @ self.B + np.diag(self.variable_weights)
        self.f = -(gain @ self.tau)
        self._polygons = polygons
        of_thruster = [self._rows(int(j)) for j in rotating]
        ends = np.cumsum([0, *map(len, of_thruster)]).tolist()
        self.rows: tuple[slice, ...] = tuple(slice(a, b) for a, b in itertools.pairwise(ends))
        rows = np.zeros((ends[-1], m))
        limits = np.empty(ends[-1])
        for i, (at, found) in enumerate(zip(self.rows, of_thruster, strict=True)):
            rows[at, k + 2 * i : k + 2 * i + 2] = found[:, :2]
            limits[at] = found[:, 2]
        if coupling is not None:
            shared = np.empty((len(coupling.b), m))
            shared[:, :k] = (coupling.a[:, fixed] * directions).sum(axis=2)
            shared[:, k:] = coupling.a[:, rotating].reshape(len(coupling.b), 2 * r)
            rows, limits = np.vstack((rows, shared)), np.concatenate((limits, coupling.b))
        self.A = rows
        self.b_lower = np.concatenate((plans[fixed, 1], np.full(len(limits), -np.inf)))
        self.b_upper = np.concatenate((plans[fixed, 2], limits))
        self.gradient_floor = _SMALLEST_SLACK * float(weights.slack.min())

    @property
    def variables(self) -> int:
        """Number of variables m."""
        return len(self.H)

    @property
    def bounds(self) -> int:
        """Number k of variables with bounds of their own: the first ones."""
        return len(self.fixed)

    @cached_property
    def variable_weights(self) -> FloatArray:
        """Diagonal of W_u^2 over the variables, shape (m,)."""
        return self.weights.thrust[[*self.fixed, *(j for j in self.rotating for _ in range(2))]]

    def _rows(self, j: int) -> FloatArray:
        """Return the rows (a_x, a_y, b) of rotating thruster ``j``, shape (k, 3)."""
        if self._polygons is None:
            _, lower, upper, azimuth, low, high = self.plans[j].tolist()
            return np.array(rotating_rows(azimuth, low, high, lower, upper, self.weights.zero_region))
        corners, count = self._polygons
        corner = corners[j, : count[j]]
        edge = np.roll(corner, -1, axis=0) - corner
        outward = np.column_stack((edge[:, 1], -edge[:, 0])) / np.linalg.norm(edge, axis=1)[:, None]
        return np.column_stack((outward, (outward * corner).sum(axis=1)))

    def polygons(self) -> tuple[FloatArray, IntArray]:
        """Return the corners of what every thruster may give, shape (n, c, 2), N, and how many, shape (n,)."""
        if self._polygons is not None:
            return self._polygons
        n = len(self.plans)
        corners, count = np.zeros((n, CORNERS, 2)), np.zeros(n, dtype=np.int64)
        set_polygons(self.plans, self.weights.zero_region, corners, count)
        return corners, count

    def forces(self, z: FloatArray) -> FloatArray:
        """Return the Cartesian thrusts (T_x, T_y) of every thruster at ``z``, shape (n, 2), N; zero for a lost one."""
        force = np.zeros((len(self.plans), 2))
        k = self.bounds
        for i, j in enumerate(self.fixed):
            azimuth = self.plans[j, 3]
            force[j] = z[i] * np.cos(azimuth), z[i] * np.sin(azimuth)
        for i, j in enumerate(self.rotating):
            force[j] = z[k + 2 * i : k + 2 * i + 2]
        return force

    def objective(self, z: FloatArray) -> float:
        """Return z' H z / 2 + f' z + c at ``z``, shape (m,); summed from squares, which keeps its precision."""
        slack = self.slack(z)
        return 0.5 * float(self.weights.slack @ slack**2 + self.variable_weights @ z**2)

    def slack(self, z: FloatArray) -> FloatArray:
        """Return s = tau - B z, shape (m,)."""
        return self.tau - self.B @ z

    def slack_form(self) -> SlackForm:
        """Return the problem with the slack as a variable."""
        m, k, p = self.variables, self.bounds, len(self.tau)
        scale = _SLACK_FORM_WEIGHT / float(self.weights.slack.min())
        lower, upper = np.full(m + p, -np.inf), np.full(m + p, np.inf)
        lower[:k], upper[:k] = self.b_lower[:k], self.b_upper[:k]
        return SlackForm(
            P=np.diag(scale * np.concatenate([self.variable_weights, self.weights.slack])),
            E=np.hstack([self.B, np.eye(p)]),
            tau=self.tau.copy(),
            G=np.hstack([self.A, np.zeros((len(self.A), p))]),
            h=self.b_upper[k:].copy(),
            lower=lower,
            upper=upper,
            scale=scale,
        )
