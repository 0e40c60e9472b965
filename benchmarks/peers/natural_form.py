"""The quadratic program as [Ruth] (4.20)-(4.22) states it, slack variables and gamma = 1000 included."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.program.problem import AllocationProblem


class NaturalForm(NamedTuple):
    """Minimise x' P x / 2, x = [z (m), s (3)], subject to E x = tau, G x <= h, lower <= x <= upper."""

    P: FloatArray
    E: FloatArray
    tau: FloatArray
    G: FloatArray
    h: FloatArray
    lower: FloatArray
    upper: FloatArray


def natural_form(problem: AllocationProblem) -> NaturalForm:
    """Return ``problem`` with the weights as they stand: x' P x / 2 is the cost (4.20)."""
    form = problem.slack_form()
    # The slack form is scaled for the sake of solvers, and its objective is half of the cost.
    return NaturalForm(
        np.asarray(form.P * (2.0 / form.scale)), form.E, form.tau, form.G, form.h, form.lower, form.upper
    )
