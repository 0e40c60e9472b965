"""The wind over the vessel."""

from __future__ import annotations

import math

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from vessel_sim.hull import Triple
from vessel_sim.settings import WindSettings
from vessel_sim.slow_variation import SlowVariation
from vessel_sim.wind import npd
from vessel_sim.wind.gusts import components
from vessel_sim.wind.load import speed_now, wind_load

_CALM: Triple = (0.0, 0.0, 0.0)
_STEADY = np.zeros((0, 3))


class Wind:
    """Wind, uniform over the hull, at the height of the centroid of its lateral area.

    ``wind.speed`` holds at 10 m above the sea at full scale; the speed at the centroid follows from the profile of
    NORSOK N-003, worked out at full scale as well. Gusts blow along the mean wind. With a speed of 0 there is no wind
    force, not even the resistance of still air, at 0.1 m/s some 0.1 % of that of the water.

    Parameters
    ----------
    vessel
        With ``wind_forces``, if the wind is to blow.
    settings
        The wind at the start.
    seed
        Of the run.
    """

    def __init__(self, vessel: Vessel, settings: WindSettings, seed: int) -> None:
        self._vessel = vessel
        self._seed = seed
        self._turn = SlowVariation(seed, "wind_direction", 1)
        forces = vessel.wind_forces
        self._constants: FloatArray = np.zeros(0) if forces is None else forces.constants()
        self._table: FloatArray = np.zeros((0, 4)) if forces is None else forces.table()
        self.apply(settings)

    def apply(self, settings: WindSettings) -> None:
        """Let another wind blow from now on; the vessel has ``wind_forces`` if it is to blow at all."""
        self._settings = settings
        self._mean = 0.0
        self._gusts = _STEADY
        forces = self._vessel.wind_forces
        if forces is None or settings.speed == 0.0:
            return
        scale, height = self._vessel.scale, forces.centroid_height
        root = math.sqrt(scale)
        self._mean = npd.speed_at(height * scale, settings.speed * root) / root
        if settings.gusts:
            self._gusts = components(settings.components, settings.speed, height, scale, self._seed)

    @property
    def blows(self) -> bool:
        """Whether there is any wind."""
        return self._settings.speed > 0.0

    def advance(self, dt: float) -> None:
        """Let the direction vary for ``dt`` (s)."""
        if self.blows and self._settings.direction_variation > 0.0:
            self._turn.advance(dt, self._settings.time_constant)

    @property
    def _direction(self) -> float:
        return self._settings.direction + self._settings.direction_variation * self._turn.values[0]

    def velocity(self, time: float) -> tuple[float, float]:
        """Return the velocity of the air at ``time`` (s): north and east, m/s."""
        speed, direction = float(speed_now(self._mean, self._gusts, time)), self._direction
        return speed * math.cos(direction), speed * math.sin(direction)

    def force(self, time: float, heading: float, u: float, v: float) -> Triple:
        """Return the force (N, N, N m; body frame) at ``time`` (s) on a hull that moves with (u, v) over ground."""
        if not self.blows:
            return _CALM
        x, y, n = wind_load(self._constants, self._table, self._gusts, self._mean, self._direction, time, heading, u, v)
        return x, y, n
