"""One regular wave train whose amplitude moves to a target."""

from __future__ import annotations

import math

from vessel_sim.settings import WaveSettings


class WaveTrain:
    """Waves of one period and direction whose amplitude moves linearly to a target."""

    __slots__ = ("_rate", "amplitude", "cos_beta", "omega", "settings", "sin_beta", "target", "wave_number")

    def __init__(self, settings: WaveSettings) -> None:
        self.settings = settings
        self.omega = 2.0 * math.pi / settings.period
        self.wave_number = settings.wave_number
        self.cos_beta = math.cos(settings.direction)
        self.sin_beta = math.sin(settings.direction)
        self.amplitude = 0.0
        self.target = 0.0
        self._rate = 0.0

    @property
    def growth(self) -> float:
        """Rate of change of the amplitude now, m/s."""
        return math.copysign(self._rate, self.target - self.amplitude) if self.ramping() else 0.0

    @property
    def component(self) -> tuple[float, float, float, float, float, float, float]:
        """Row of ``vessel_sim.waves.components`` now."""
        return self.wave_number, self.omega, self.cos_beta, self.sin_beta, self.amplitude, self.growth, 0.0

    def ramping(self) -> bool:
        """True until the amplitude has reached its target."""
        return self.amplitude != self.target

    def aim(self, amplitude: float, ramp: float) -> None:
        """Let the amplitude reach ``amplitude`` (m) in ``ramp`` (s); at once if that is 0."""
        self.target = amplitude
        if ramp > 0.0:
            self._rate = abs(amplitude - self.amplitude) / ramp
        else:
            self.amplitude = amplitude

    def advance(self, dt: float) -> None:
        """Move the amplitude on by ``dt`` (s)."""
        change = self._rate * dt
        if abs(self.target - self.amplitude) <= change:
            self.amplitude = self.target
        else:
            self.amplitude += math.copysign(change, self.target - self.amplitude)

    def phase(self, north: float, east: float, time: float) -> float:
        """Return theta, rad."""
        return self.wave_number * (north * self.cos_beta + east * self.sin_beta) - self.omega * time
