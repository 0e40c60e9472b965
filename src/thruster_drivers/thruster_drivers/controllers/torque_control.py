"""Laws that ask for a torque without feedback of the shaft speed error, and how one passes to another."""

from __future__ import annotations

import math
from abc import abstractmethod

from thruster_drivers.controllers.base import ControlOutput, ThrusterController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class FeedforwardController(ThrusterController):
    """The torque of a law and the friction at n_d, held within the limits.

    Friction is taken at the desired shaft speed: it then has the sign of thrust when the shaft stands still, and gives
    nothing more to a propeller that races.

    After a change of law the difference to the torque before it fades linearly, in the transfer time, and no sooner
    than the pitch has arrived: the new law's torque belongs to its own pitch, and would race a propeller of less.
    """

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._transfer_time = tuning.transfer_time
        self._offset = 0.0  # N m, torque before the change of law less this law's
        self._weight = 0.0  # how much of it still counts
        self._left = 0.0  # of the transfer time, as a fraction
        self._pitch_way = 0.0  # from the pitch found at the change of law to the one wanted

    @abstractmethod
    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return propeller torque Q_d, N m, shaft speed n_d at which it is met, Hz, and the pitch ratio wanted.

        ``shaft_speed`` is the measured one, not finite where the sensor is lost.
        """

    def step(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, dt: float) -> ControlOutput:
        """Return motor torque and pitch set point; see the base class."""
        torque, desired, wanted = self._aim(thrust_reference, shaft_speed)
        self.shaft_speed_reference = desired
        pitch = self._pitch.follow(wanted, pitch_ratio, dt)
        torque += self._model.friction(desired)
        if self._weight > 0.0:
            torque += self._weight * self._offset
            self._fade(abs(wanted - pitch), dt)
        least, most = self._limits.constant or self._limits.bounds(
            shaft_speed if math.isfinite(shaft_speed) else desired, dt
        )
        return ControlOutput(least if torque < least else most if torque > most else torque, pitch)

    def take_over(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, torque: float) -> None:
        """Remember how far ``torque`` is from this law's; see the base class."""
        self._pitch.start(pitch_ratio)
        own, desired, wanted = self._aim(thrust_reference, shaft_speed)
        self._offset = torque - own - self._model.friction(desired)
        self._weight = self._left = 1.0
        self._pitch_way = 0.0 if self._pitch.fixed else abs(wanted - self._pitch.value)

    def _fade(self, to_go: float, dt: float) -> None:
        self._left = max(0.0, self._left - dt / self._transfer_time)
        share = to_go / self._pitch_way if self._pitch_way > 0.0 else 0.0
        self._weight = min(self._weight, max(self._left, share))
