"""What every sea can be asked."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from vessel_sim.waves.components import elevation, particle_velocity


class Sea(ABC):
    """A sum of linear deep-water wave components."""

    @property
    @abstractmethod
    def components(self) -> FloatArray:
        """Components now, shape (m, ``components.WIDTH``); see ``vessel_sim.waves.components`` for the columns."""

    def elevation(self, north: ArrayLike, east: ArrayLike, time: ArrayLike) -> FloatArray:
        """Return the undisturbed elevation, m, positive up.

        Parameters
        ----------
        north, east
            m; arrays of any shape, broadcast.
        time
            s, broadcast with them.
        """
        full = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (north, east, time)))
        return _elevations(self.components, *(np.array(a).ravel() for a in full)).reshape(full[0].shape)

    def particle_velocity(self, north: ArrayLike, east: ArrayLike, depth: ArrayLike, time: ArrayLike) -> FloatArray:
        """Return the velocity of the water, m/s in NED, in a new last axis of length 3.

        Parameters
        ----------
        north, east
            m; arrays of any shape, broadcast.
        depth
            m below the calm surface; above it (negative) the velocity is that at the surface.
        time
            s.
        """
        full = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (north, east, depth, time)))
        return _particle_velocities(self.components, *(np.array(a).ravel() for a in full)).reshape((*full[0].shape, 3))


@compiled
def _elevations(components: FloatArray, north: FloatArray, east: FloatArray, time: FloatArray) -> FloatArray:
    found = np.empty(north.size)
    for i in range(north.size):
        found[i] = elevation(components, north[i], east[i], time[i])
    return found


@compiled
def _particle_velocities(
    components: FloatArray, north: FloatArray, east: FloatArray, depth: FloatArray, time: FloatArray
) -> FloatArray:
    found = np.empty((north.size, 3))
    for i in range(north.size):
        found[i, 0], found[i, 1], found[i, 2] = particle_velocity(components, north[i], east[i], depth[i], time[i])
    return found
