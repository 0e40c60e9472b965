"""Uniform current that varies slowly."""

from __future__ import annotations

import math

from vessel_sim.settings import CurrentSettings
from vessel_sim.slow_variation import SlowVariation


class Current:
    """Speed and direction with first-order Gauss-Markov variations about their means.

    Where the speed would become negative, the current sets the other way.

    Parameters
    ----------
    settings
        The current at the start.
    seed
        Of the run.
    """

    def __init__(self, settings: CurrentSettings, seed: int) -> None:
        self.settings = settings
        self._variation = SlowVariation(seed, "current", 2)

    @property
    def velocity(self) -> tuple[float, float]:
        """North and east, m/s."""
        settings = self.settings
        faster, turned = self._variation.values
        speed = settings.speed + settings.variation * faster
        direction = settings.direction + settings.direction_variation * turned
        return speed * math.cos(direction), speed * math.sin(direction)

    @property
    def varies(self) -> bool:
        """Whether it varies at all."""
        return self.settings.variation > 0.0 or self.settings.direction_variation > 0.0

    def advance(self, dt: float) -> bool:
        """Let it vary for ``dt`` (s); return whether it does."""
        varies = self.varies
        if varies:
            self._variation.advance(dt, self.settings.time_constant)
        return varies
