"""What a configuration of thrusters can do through its pseudo-inverse, kept from step to step while it stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.feasible.directions import along_direction
from thrust_allocator.feasible.octahedron import Group, coupled_axes, served_limits
from thrust_allocator.feasible.pseudo_inverse import pseudo_inverse


class Configuration:
    """B at given angles, B*, the limits that it serves, and which axes share thrusters.

    Parameters
    ----------
    vessel
        Geometry, and weights of a miss by axis.
    """

    def __init__(self, vessel: Vessel) -> None:
        self._columns = vessel.columns
        self._axis_weight = np.array(vessel.allocator.slack_weight)
        self._key = b""
        self.groups: tuple[Group, ...] = ()
        self.inverse = np.zeros((len(vessel.thrusters), len(vessel.degrees_of_freedom)))
        self.limits = np.zeros(len(vessel.degrees_of_freedom))

    def point(self, azimuth: FloatArray, used: NDArray[np.bool_], thrust_max: FloatArray) -> None:
        """Take the directions (rad), which thrusters are in use, and f^max (N), each of shape (n,)."""
        key = azimuth.tobytes() + used.tobytes() + thrust_max.tobytes()
        if key == self._key:
            return
        self._key = key
        B = along_direction(self._columns, azimuth).T
        self.inverse = pseudo_inverse(B, used, self._axis_weight)
        self.groups = coupled_axes(np.where(used, B, 0.0))
        self.limits = served_limits(B, thrust_max, self.inverse)
