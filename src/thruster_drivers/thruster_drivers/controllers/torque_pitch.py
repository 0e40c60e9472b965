"""Torque/pitch control, [Ruth] (3.17)-(3.18)."""

from __future__ import annotations

from thruster_drivers.controllers.controllable_pitch import OptimalSetpoints
from thruster_drivers.controllers.torque_control import FeedforwardController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class TorquePitchController(FeedforwardController):
    """The pitch ratio of least power at the assumed advance speed, and the torque that gives the thrust with it."""

    needs_pitch = True

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._optimum = OptimalSetpoints(model, tuning.advance_speed)

    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return h(tau_d) D T_d, [Ruth] (3.17), n_d of (3.19), and k(tau_d) of (3.18)."""
        pitch, torque, desired = self._optimum.at(thrust_reference)
        return torque, desired, pitch
