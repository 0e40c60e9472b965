"""Set point of the pitch ratio, within range and rate of the actuator."""

from __future__ import annotations

import math

from thruster_drivers.shaft_model import ShaftModel


class PitchSetpoint:
    """Follows what a law wants no faster than the actuator can.

    It starts from the measured pitch ratio, so that neither a start under way nor a change of law makes it jump.

    Parameters
    ----------
    model
        Design pitch ratio and actuator; without one the set point is the design's, always.
    """

    def __init__(self, model: ShaftModel) -> None:
        self.fixed = model.pitch is None
        self.design = self.value = model.pitch_ratio
        self._started = self.fixed
        if model.pitch is not None:
            self._min, self._max, self._rate = model.pitch.min, model.pitch.max, model.pitch.rate

    def start(self, measured: float) -> None:
        """Set out from ``measured``; where that is not finite, from where the set point is."""
        if not self.fixed:
            self._started = True
            if math.isfinite(measured):
                self.value = max(self._min, min(self._max, measured))

    def follow(self, wanted: float, measured: float, dt: float) -> float:
        """Return the set point after ``dt`` (s) on its way to ``wanted``."""
        if self.fixed:
            return self.value
        if not self._started:
            self.start(measured)
        target = max(self._min, min(self._max, wanted))
        move = self._rate * dt
        self.value += max(-move, min(move, target - self.value))
        return self.value
