"""Power control, [Ruth] (3.11)-(3.12)."""

from __future__ import annotations

import math

from thruster_drivers.controllers.torque_control import FeedforwardController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class PowerController(FeedforwardController):
    """The power that belongs to the desired thrust at zero advance speed, whatever the shaft speed.

    With P_d = 2 pi n_d Q_d, [Ruth] (3.12) is Q_d n_d / n: torque control's torque times n_d / n, which has no end
    where the shaft stands still. The ratio is held to ``torque_ratio_max``, c. It cannot bind in steady state below
    K_Q = c^3 K_Qc, where the shaft would turn at n_d / c under c Q_d: with c = 2 at eight times the torque coefficient
    of bollard pull. A shaft that stands, or still turns against the thrust, is brought up with c Q_d.
    """

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._torque_per_thrust = model.torque_per_speed_squared / model.thrust_per_speed_squared
        self._ratio_max = tuning.torque_ratio_max

    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return the torque that gives P_d, n_d of (3.8), and the design pitch ratio."""
        desired = self._model.shaft_speed(thrust_reference)
        torque = self._torque_per_thrust * thrust_reference
        if math.isfinite(shaft_speed):
            torque *= self._torque_ratio(desired, shaft_speed)
        return torque, desired, self._pitch.design

    def _torque_ratio(self, desired: float, shaft_speed: float) -> float:
        """Return n_d / n, held to 0 ... c; without a measured shaft speed it would be 1."""
        along = shaft_speed if desired >= 0.0 else -shaft_speed
        size = abs(desired)
        return size / along if along * self._ratio_max > size else self._ratio_max
