"""Combined torque and power control, [Ruth] (3.13)-(3.14)."""

from __future__ import annotations

import math

from thruster_drivers.controllers.power import PowerController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel

# |p n| beyond this is power control whatever k and r, and its power must not overflow.
_FAR = 1e9


class CombinedController(PowerController):
    """Torque control at low shaft speed, power control at high, weighted by alpha(n) = exp(-k |p n|^r).

    Without a time p in the vessel file 1/p is the shaft speed at half of the largest thrust.
    """

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._gain = tuning.combined_gain
        self._time = tuning.combined_time or 1.0 / model.shaft_speed(0.5 * model.thrust_max)
        self._exponent = tuning.combined_exponent

    def _torque_ratio(self, desired: float, shaft_speed: float) -> float:
        """Return alpha + (1 - alpha) n_d / n."""
        scaled = abs(shaft_speed) * self._time
        weight = math.exp(-self._gain * min(scaled, _FAR) ** self._exponent)
        return weight + (1.0 - weight) * super()._torque_ratio(desired, shaft_speed)
