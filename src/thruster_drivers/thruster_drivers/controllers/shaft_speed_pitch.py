"""Shaft-speed/pitch control, [Ruth] (3.19)-(3.21)."""

from __future__ import annotations

from thruster_drivers.controllers.controllable_pitch import OptimalSetpoints
from thruster_drivers.controllers.speed_control import SpeedController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class ShaftSpeedPitchController(SpeedController):
    """The pitch ratio of least power at the assumed advance speed, and the shaft speed that then gives the thrust."""

    needs_pitch = True

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._optimum = OptimalSetpoints(model, tuning.advance_speed)
        self._propeller_torque = 0.0

    def _aim(self, thrust_reference: float) -> tuple[float, float]:
        """Return n_d of [Ruth] (3.19) and k(tau_d) of (3.20)."""
        pitch, self._propeller_torque, desired = self._optimum.at(thrust_reference)
        return desired, pitch

    def _load(self, desired: float, pitch_ratio: float) -> float:
        """Return the load torque (N m) at the best pitch ratio, h(tau_d) D T_d of (3.17), and friction."""
        return self._propeller_torque + self._model.friction(desired)
