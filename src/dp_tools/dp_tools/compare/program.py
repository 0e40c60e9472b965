"""The constrained quadratic program with limits of thrust alone: the allocator's cost, without rates of change."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from dp_tools.compare.group import Group
from marine_model import Vessel
from marine_model.guards import FloatArray

# Length of the weighted slack over that of the weighted demand below which a demand counts as attained. The slack is
# soft: within the attainable set it is (W_u / gamma)^2 of the demand, 1e-6, and what is 0.1 % outside has 1e-3.
ATTAINED = 1e-4


class ConstrainedProgram:
    """Minimise |gamma W_v (tau - B f)|^2 + |W_u f|^2 with every thrust within its limits: (4.20) of [Ruth].

    Solved as a bounded least-squares problem, by an active-set method that ends at the exact optimum.

    Parameters
    ----------
    vessel, group
        Weights of the one; columns and limits of the other.
    """

    def __init__(self, vessel: Vessel, group: Group) -> None:
        gains = vessel.allocator
        self._columns = group.columns
        self._slack_weight = gains.slack_gain * np.array(gains.slack_weight)[list(group.places)]
        self._thrust_weight = np.array(gains.thrust_weight)[list(group.thrusters)]
        self._matrix = np.vstack([self._slack_weight[:, None] * group.columns, np.diag(self._thrust_weight)])
        self._bounds = group.lower, group.upper

    def thrusts(self, demand: FloatArray) -> FloatArray:
        """Return the thrusts for a demand (m,), shape (k,), N."""
        wanted = np.concatenate([self._slack_weight * demand, np.zeros(len(self._thrust_weight))])
        found: FloatArray = lsq_linear(self._matrix, wanted, bounds=self._bounds, method="bvls", tol=1e-12).x
        return found

    def missed(self, demand: FloatArray, thrusts: FloatArray) -> float:
        """Return the length of the weighted slack over that of the weighted demand; ``demand`` is not zero."""
        slack = demand - self._columns @ thrusts
        return float(np.linalg.norm(self._slack_weight * slack) / np.linalg.norm(self._slack_weight * demand))
