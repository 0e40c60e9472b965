"""SciPy's SLSQP on the quadratic program, with exact gradients.

It is given the form that it does best on: slack eliminated, cost in units of the smallest slack weight. With slack
variables and the weights as they stand it stops early, newtons away, or fails.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.demands import Step
from benchmarks.peers.peer import Commands, Peer, polar_form, titled

_TOLERANCE = 1e-9  # of the cost in those units
_ITERATIONS = 200


class Slsqp(Peer):
    """scipy.optimize.minimize(method="SLSQP"), started from the command of the step before."""

    @property
    def name(self) -> str:
        """Stable name."""
        return "slsqp"

    @property
    def title(self) -> str:
        """What it is."""
        return f"{titled('scipy')} SLSQP, exact gradients, ftol {_TOLERANCE:g}"

    def prepare(self, step: Step) -> Any:
        """Return the arguments of minimize."""
        problem = step.problem
        k = problem.bounds
        unit = float(problem.weights.slack.min())
        H, f = problem.H / unit, problem.f / unit
        A, limit = problem.A.copy(), problem.b_upper[k:].copy()
        free = np.full(problem.variables - k, np.inf)
        return {
            "fun": lambda z: (0.5 * float(z @ H @ z) + float(f @ z), H @ z + f),
            "jac": True,
            "x0": _variables_before(step),
            "bounds": np.column_stack(
                [np.concatenate([problem.b_lower[:k], -free]), np.concatenate([problem.b_upper[:k], free])]
            ),
            "constraints": [{"type": "ineq", "fun": lambda z: limit - A @ z, "jac": lambda z: -A}] if len(A) else [],
            "method": "SLSQP",
            "options": {"ftol": _TOLERANCE, "maxiter": _ITERATIONS},
        }

    def solve(self, task: Any) -> Any:
        """Minimise."""
        return minimize(**task)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return the commands of an answer that was found."""
        return polar_form(step, answer.x) if answer.success else None


def _variables_before(step: Step) -> Any:
    """Return the command of the step before as variables of the problem."""
    thrust, azimuth = step.thrust_before, step.azimuth_before
    z = [thrust[j] for j in step.problem.fixed]
    for j in step.problem.rotating:
        z += [thrust[j] * np.cos(azimuth[j]), thrust[j] * np.sin(azimuth[j])]
    return np.array(z)
