"""method = pseudo_inverse: (2.3) of [Garus-F], with what is infeasible reduced before as ``feasible`` says."""

from __future__ import annotations

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.feasible.octahedron import octahedron_load, reduce_proportionally
from thrust_allocator.feasible.priority import reduce_by_priority
from thrust_allocator.methods.configuration import Configuration
from thrust_allocator.methods.method import Method, Wanted, both_ways, thrust_range
from thrust_allocator.plan.phase import Plan


class PseudoInverseMethod(Method):
    """The pseudo-inverse of the thrusters in use, where they point.

    Parameters
    ----------
    vessel
        Geometry.
    feasible
        none, proportional or priority.
    axis
        Index of the axis that priority keeps, among the degrees of freedom.
    weights
        Of priority, shape (m,).
    """

    def __init__(self, vessel: Vessel, feasible: str, axis: int, weights: FloatArray) -> None:
        self._axes = vessel.degrees_of_freedom
        self._configuration = Configuration(vessel)
        self._feasible, self._axis, self._weights = feasible, axis, weights

    def want(self, plans: FloatArray, limits: FloatArray, tau: FloatArray) -> Wanted:
        """Reduce the demand, group by group of axes that share thrusters, and divide it."""
        lower, upper = thrust_range(limits)
        configuration = self._configuration
        configuration.point(plans[:, Plan.AZIMUTH].copy(), upper > lower, both_ways(limits))
        feasible, load = tau.copy(), 0.0
        for group in map(list, configuration.groups):
            most = configuration.limits[group]
            load = max(load, float(octahedron_load(tau[group], most)))
            if self._feasible == "proportional":
                feasible[group] = reduce_proportionally(tau[group], most)
            elif self._feasible == "priority":
                kept = group.index(self._axis) if self._axis in group else None
                feasible[group] = reduce_by_priority(tau[group], most, self._weights[group], kept)
        detail = ""
        if load > 1.0 and self._feasible != "none":
            idle = [axis for axis, most in zip(self._axes, configuration.limits, strict=True) if most == 0.0]
            detail = f"no thruster serves {', '.join(idle)}" if idle else f"{load:.3g} times the octahedron demanded"
        thrust = configuration.inverse @ feasible
        return Wanted(np.clip(thrust, lower, upper), feasible, load, detail)
