"""PI control of the shaft speed by motor torque: the inner loop of three laws, [Ruth] (3.9), (3.15), (3.21)."""

from __future__ import annotations

import math
from abc import abstractmethod

from thruster_drivers.controllers.base import ControlOutput, ThrusterController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class SpeedController(ThrusterController):
    """PI on shaft speed with feedforward of the load at the desired speed.

    The shaft obeys 2 pi J dn/dt = Q_m - K_Q rho D^5 n|n| - Q_f, so with K_p = 2 pi J omega_b the error decays
    with the bandwidth omega_b whatever the inertia, and T_i = 4 / omega_b damps the pair critically.

    [Ruth] prints PID(n - n_d), which needs negative gains; here the error is n_d - n and the gains are positive. There
    is no derivative action: the measured shaft speed is noisy. The load torque is fed forward at n_d, not at the
    measurement, for the same reason.
    """

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        self._speed_max = model.speed_max
        self._proportional_gain = 2.0 * math.pi * model.inertia * tuning.bandwidth
        self._integral_gain = self._proportional_gain / tuning.integral_time
        # After a gap in the measurements one error must not count for longer than the integral remembers.
        self._integration_step_max = tuning.integral_time
        self._integral = 0.0

    @property
    def integral(self) -> float:
        """Torque of the integral term, N m."""
        return self._integral

    @abstractmethod
    def _aim(self, thrust_reference: float) -> tuple[float, float]:
        """Return the desired shaft speed n_d, Hz, and the pitch ratio wanted."""

    def _load(self, desired: float, pitch_ratio: float) -> float:
        """Return the motor torque (N m) expected at the desired shaft speed (Hz) and ``pitch_ratio``."""
        return self._model.load_torque(desired)

    def step(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, dt: float) -> ControlOutput:
        """Return motor torque and pitch set point; see the base class."""
        desired, wanted = self._aim(thrust_reference)
        speed_max = self._speed_max
        if not -speed_max <= desired <= speed_max:
            desired = math.copysign(speed_max, desired)
        self.shaft_speed_reference = desired
        pitch = self._pitch.value if self._pitch.fixed else self._pitch.follow(wanted, pitch_ratio, dt)
        if not math.isfinite(shaft_speed):
            shaft_speed = desired  # open loop: feedforward, and the integral stays as it was
        error = desired - shaft_speed
        least, most = self._limits.constant or self._limits.bounds(shaft_speed, dt)
        increment = self._integral_gain * error * min(dt, self._integration_step_max)
        torque = self._load(desired, pitch) + self._proportional_gain * error + self._integral + increment
        # Anti-windup: at a limit the integral may only move back from it.
        if torque > most:
            if increment < 0.0:
                self._integral += increment
            return ControlOutput(most, pitch)
        if torque < least:
            if increment > 0.0:
                self._integral += increment
            return ControlOutput(least, pitch)
        self._integral += increment
        return ControlOutput(torque, pitch)

    def take_over(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, torque: float) -> None:
        """Give the integral what the other terms leave of ``torque``; see the base class."""
        desired, _ = self._aim(thrust_reference)
        speed_max = self._speed_max
        if not -speed_max <= desired <= speed_max:
            desired = math.copysign(speed_max, desired)
        self._pitch.start(pitch_ratio)
        error = desired - shaft_speed if math.isfinite(shaft_speed) else 0.0
        self._integral = torque - self._load(desired, self._pitch.value) - self._proportional_gain * error
