"""The constrained quadratic program of the allocator with limits of thrust alone, without rates of change."""

from __future__ import annotations

import numpy as np

from dp_tools.compare.group import Group
from marine_model import Vessel
from marine_model.errors import DpError
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import FIXED, Plan
from thrust_allocator.program.daqp_solver import DaqpSolver
from thrust_allocator.program.problem import AllocationProblem, Weights

# Length of the weighted slack over that of the weighted demand below which a demand counts as attained. The slack is
# soft: within the attainable set it is (W_u / gamma)^2 of the demand, 1e-6, and what is 0.1 % outside has 1e-3.
ATTAINED = 1e-4


class ConstrainedProgram:
    """[Ruth] (4.20) for demands in a group of axes, thrusters along their fixed directions.

    Parameters
    ----------
    vessel, group
        The vessel, and which of its axes.
    """

    def __init__(self, vessel: Vessel, group: Group) -> None:
        self._group = group
        self._weights = Weights.of(vessel)
        self._slack_weight = np.sqrt(self._weights.slack[list(group.places)])
        self._plans = np.zeros((len(vessel.thrusters), Plan.COLUMNS))
        self._plans[:, Plan.PHASE] = FIXED
        self._plans[:, Plan.LOWER], self._plans[:, Plan.UPPER] = vessel.thrust_min, vessel.thrust_max
        self._plans[:, Plan.AZIMUTH] = vessel.fixed_direction
        self._solver = DaqpSolver()

    def thrusts(self, demand: FloatArray) -> FloatArray:
        """Return the thrusts of the group for a demand (m,), shape (k,), N.

        Raises
        ------
        DpError
            If the solver fails.
        """
        tau = np.zeros(len(self._weights.slack))
        tau[list(self._group.places)] = demand
        solution = self._solver.solve(AllocationProblem(self._weights, self._plans, tau))
        if solution is None or solution.message:
            raise DpError(f"quadratic program: no solution for {demand.tolist()}")
        thrusts: FloatArray = solution.z[list(self._group.thrusters)]
        return thrusts

    def missed(self, demand: FloatArray, thrusts: FloatArray) -> float:
        """Return the length of the weighted slack over that of the weighted demand; ``demand`` is not zero."""
        slack = demand - self._group.columns @ thrusts
        return float(np.linalg.norm(self._slack_weight * slack) / np.linalg.norm(self._slack_weight * demand))
