"""SciPy's SLSQP on the quadratic program, with exact gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.demands import Step
from benchmarks.peers.natural_form import natural_form
from benchmarks.peers.peer import Commands, Peer, polar_form, titled

_TOLERANCE = 1e-9  # of the cost; the default of 1e-6 ends a little earlier
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
        form = natural_form(step.problem)
        weights = np.diag(form.P).copy()
        constraints = [{"type": "eq", "fun": lambda x: form.E @ x - form.tau, "jac": lambda x: form.E}]
        if len(form.h):
            constraints.append({"type": "ineq", "fun": lambda x: form.h - form.G @ x, "jac": lambda x: -form.G})
        z = _variables_before(step)
        start = np.concatenate([z, step.problem.tau - step.problem.B @ z])
        return {
            "fun": lambda x: (0.5 * float(weights @ x**2), weights * x),
            "jac": True,
            "x0": start,
            "bounds": np.column_stack([form.lower, form.upper]),
            "constraints": constraints,
            "method": "SLSQP",
            "options": {"ftol": _TOLERANCE, "maxiter": _ITERATIONS},
        }

    def solve(self, task: Any) -> Any:
        """Minimise."""
        return minimize(**task)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return the commands of an answer that was found."""
        return polar_form(step, answer.x[: step.problem.variables]) if answer.success else None


def _variables_before(step: Step) -> Any:
    """Return the command of the step before as variables of the problem."""
    thrust, azimuth = step.thrust_before, step.azimuth_before
    z = [thrust[j] for j in step.problem.fixed]
    for j in step.problem.rotating:
        z += [thrust[j] * np.cos(azimuth[j]), thrust[j] * np.sin(azimuth[j])]
    return np.array(z)
