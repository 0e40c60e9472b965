"""Limits of torque, power and shaft speed: one place for all laws."""

from __future__ import annotations

import math

from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel

_TWO_PI = 2.0 * math.pi


class ShaftLimits:
    """The least and the largest motor torque that a thruster may be asked for now.

    - Torque: |Q| <= Q_max.
    - Power: |2 pi n Q| <= P_max.
    - Shaft speed: a PI controller at n_max, of the gains of the shaft-speed loop, gives the largest torque that may be
      asked for, and one at -n_max the least. Fed forward is the load at n_max, and the integral only ever lowers the
      bound: a thruster that reaches its thrust at or below n_max never meets it, one whose load goes away is held
      at n_max.

    Parameters
    ----------
    model
        Limits and load.
    tuning
        Gains of the shaft-speed loop.
    """

    constant: tuple[float, float] | None
    """What :meth:`bounds` always gives, where only torque has a limit; None elsewhere."""

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        self._torque_max = model.torque_max
        self._power_per_turn = model.power_max / _TWO_PI
        self._speed_max = model.speed_max
        only_torque = math.isinf(model.power_max) and math.isinf(model.speed_max)
        self.constant = (-model.torque_max, model.torque_max) if only_torque else None
        self._has_speed = math.isfinite(model.speed_max)
        if self._has_speed:
            self._load = model.load_torque(model.speed_max)
            self._gain = _TWO_PI * model.inertia * tuning.bandwidth
            self._integral_gain = self._gain / tuning.integral_time
            self._integration_step_max = tuning.integral_time
            # Beyond this the bound would ask for more than the whole torque backwards.
            self._integral_least = -(self._load + model.torque_max)
        self._ahead = self._astern = 0.0

    def bounds(self, shaft_speed: float, dt: float) -> tuple[float, float]:
        """Return least and largest motor torque, N m.

        Parameters
        ----------
        shaft_speed
            Hz, measured; where the sensor is lost, the desired one.
        dt
            s since the last call.
        """
        most = self._torque_max
        if abs(shaft_speed) * most > self._power_per_turn:
            most = self._power_per_turn / abs(shaft_speed)
        if not self._has_speed:
            return -most, most
        time = min(dt, self._integration_step_max)
        self._ahead, high = self._held(self._ahead, self._speed_max - shaft_speed, time)
        self._astern, low = self._held(self._astern, self._speed_max + shaft_speed, time)
        return -max(-most, min(most, low)), max(-most, min(most, high))

    def _held(self, integral: float, room: float, time: float) -> tuple[float, float]:
        """Return the integral and the torque towards a speed limit that is ``room`` (Hz) away."""
        integral = max(self._integral_least, min(0.0, integral + self._integral_gain * room * time))
        return integral, self._load + self._gain * room + integral
