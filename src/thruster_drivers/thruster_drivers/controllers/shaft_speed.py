"""Shaft-speed control, [Ruth] (3.8)-(3.9)."""

from __future__ import annotations

import math

from marine_model.gains import ShaftSpeedGains
from thruster_drivers.controllers.base import ThrusterController
from thruster_drivers.shaft_model import ShaftModel


class ShaftSpeedController(ThrusterController):
    """PI on shaft speed with feedforward of the load at the desired speed.

    The shaft obeys 2 pi J dn/dt = Q_m - K_Q rho D^5 n|n| - Q_f, so with K_p = 2 pi J omega_b the error decays
    with the bandwidth omega_b whatever the inertia, and T_i = 4 / omega_b damps the pair critically.

    [Ruth] (3.9) prints PID(n - n_d), which needs negative gains; here the error is n_d - n and the gains are
    positive. There is no derivative action: the measured shaft speed is noisy. The load torque is fed forward at
    n_d, not at the measurement, for the same reason.
    """

    def __init__(self, model: ShaftModel, gains: ShaftSpeedGains) -> None:
        self._model = model
        self._torque_max = model.torque_max
        self._proportional_gain = 2.0 * math.pi * model.inertia * gains.bandwidth
        self._integral_gain = self._proportional_gain / gains.integral_time
        # After a gap in the measurements one error must not count for longer than the integral remembers.
        self._integration_step_max = gains.integral_time
        self._integral = 0.0

    @property
    def integral(self) -> float:
        """Torque of the integral term, N m."""
        return self._integral

    def step(self, thrust_reference: float, shaft_speed: float, dt: float) -> float:
        """Return the motor torque, N m; see the base class."""
        desired = self._model.shaft_speed(thrust_reference)
        self.shaft_speed_reference = desired
        load = self._model.load_torque(desired)
        if math.isfinite(shaft_speed):
            error = desired - shaft_speed
        else:
            error = 0.0  # open loop: feedforward, and the integral stays as it was
        increment = self._integral_gain * error * min(dt, self._integration_step_max)
        torque = load + self._proportional_gain * error + self._integral + increment
        # Anti-windup: at the torque limit the integral may only move back from it.
        if torque > self._torque_max:
            if increment < 0.0:
                self._integral += increment
            return self._torque_max
        if torque < -self._torque_max:
            if increment > 0.0:
                self._integral += increment
            return -self._torque_max
        self._integral += increment
        return torque
