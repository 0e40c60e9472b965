"""Torque control, [Ruth] (3.10)."""

from __future__ import annotations

from thruster_drivers.controllers.torque_control import FeedforwardController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class TorqueController(FeedforwardController):
    """The propeller torque that belongs to the desired thrust at zero advance speed; no measurement is needed."""

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._torque_per_thrust = model.torque_per_speed_squared / model.thrust_per_speed_squared  # K_Qc D / K_Tc

    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return Q_d = K_Qc D / K_Tc T_d, [Ruth] (3.10), n_d of (3.8), and the design pitch ratio."""
        desired = self._model.shaft_speed(thrust_reference)
        return self._torque_per_thrust * thrust_reference, desired, self._pitch.design
