"""Torque/shaft-speed control, [Ruth] (3.22)-(3.24), after Schanz (1967)."""

from __future__ import annotations

import math

import numpy as np

from marine_model.errors import InputError
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.optimal import optimal_maps, pitch_of_torque_coefficient, thrust_pitches
from marine_model.thruster import PitchDrive
from thruster_drivers.controllers.base import ControlOutput
from thruster_drivers.controllers.controllable_pitch import controllable_pitch
from thruster_drivers.controllers.torque_control import FeedforwardController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel

# Step of P/D in the slope of K_Q: central, so that its error is of the order of the square.
_PITCH_STEP = 0.01


class TorqueShaftSpeedController(FeedforwardController):
    """Torque and shaft speed of the desired thrust; the pitch loads the shaft until it turns at that speed.

    The torque coefficient then is K_Qc at every advance speed, which is nearly the best without knowing it. With P_d
    of (3.11), (3.22)-(3.23) are torque (3.10) and shaft speed (3.8), K_Tc being K_T where K_Q is K_Qc at zero advance
    speed. (3.22) prints the power 2/3 of P_d under the cube root as well as outside it; P_d^2 under it is meant.

    (3.24) prints PID(n - n_d), and section 3.7 a gain of -1 beside the positive one of (3.9): with errors n_d - n in
    both, n above n_d lowers the torque there and raises the pitch here. Here the error is n - n_d along the thrust and
    the gain positive. Error and set point pass a first-order low-pass, and there is no derivative action.

    Unless the vessel file gives gains, they cancel the shaft's own pole at the largest thrust,
    T_i = 2 pi J / (2 K_Qc rho D^5 n), and put the crossover at a quarter of the servo's corner, 1 / (4 T_servo): with
    servo and filter that leaves a phase margin of 62 degrees.
    """

    needs_pitch = True

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        propeller, drive = controllable_pitch(model)
        K_T, K_Q, slope = _design_point(propeller, drive, tuning.torque_coefficient)
        scale = model.density * propeller.diameter**4
        self._torque_per_thrust = K_Q * propeller.diameter / K_T
        self._thrust_per_speed_squared = K_T * scale
        load = K_Q * scale * propeller.diameter
        largest = math.sqrt(model.thrust_max / self._thrust_per_speed_squared)
        inertia = 2.0 * math.pi * model.inertia
        self._filter_time = tuning.pitch_filter_time or drive.time_constant
        self._integral_time = tuning.pitch_integral_time or inertia / (2.0 * load * largest)
        self._gain = tuning.pitch_gain or inertia / (
            4.0 * drive.time_constant * slope * scale * propeller.diameter * largest**2
        )
        self._least, _ = thrust_pitches(propeller, (drive.min, drive.max))  # below it less pitch is more load
        self._wanted = model.pitch_ratio
        self._integral = math.nan  # P/D; found at the first step
        self._error = 0.0  # Hz, filtered

    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return Q_d, [Ruth] (3.22), n_d of (3.23), and the pitch ratio that the loop last wanted."""
        size = abs(thrust_reference) / self._thrust_per_speed_squared
        desired = math.copysign(math.sqrt(size), thrust_reference)
        return self._torque_per_thrust * thrust_reference, desired, max(self._least, self._wanted)

    def step(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, dt: float) -> ControlOutput:
        """Return motor torque and pitch set point; see the base class."""
        if self._integral != self._integral:
            self._pitch.start(pitch_ratio)
            self._integral = self._wanted = self._pitch.value
        _, desired, _ = self._aim(thrust_reference, shaft_speed)
        increment = self._regulate(desired, shaft_speed, dt)
        output = super().step(thrust_reference, shaft_speed, pitch_ratio, dt)
        # Anti-windup: where the set point lags behind, by range or rate, the integral may only move towards it.
        behind = output.pitch_ratio - self._wanted
        if behind * increment >= 0.0:
            self._integral += increment
        return output

    def take_over(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, torque: float) -> None:
        """Start torque and pitch from where they are; see the base class."""
        self._pitch.start(pitch_ratio)
        self._wanted = self._pitch.value
        super().take_over(thrust_reference, shaft_speed, pitch_ratio, torque)
        _, desired, _ = self._aim(thrust_reference, shaft_speed)
        self._error = _error(desired, shaft_speed)
        self._integral = self._wanted - self._gain * self._error

    def _regulate(self, desired: float, shaft_speed: float, dt: float) -> float:
        """Leave the pitch ratio wanted; return what the integral is to grow by."""
        if desired == 0.0 or not math.isfinite(shaft_speed):
            # Nothing to load the shaft for, or to see it by: the pitch stays.
            self._wanted = self._pitch.value
            self._integral = self._wanted - self._gain * self._error
            return 0.0
        self._error += (_error(desired, shaft_speed) - self._error) * dt / (dt + self._filter_time)
        increment = self._gain / self._integral_time * self._error * min(dt, self._integral_time)
        self._wanted = self._gain * self._error + self._integral + increment
        return increment


def _error(desired: float, shaft_speed: float) -> float:
    """Return how much faster than desired the shaft turns, Hz, along the thrust."""
    if desired == 0.0 or not math.isfinite(shaft_speed):
        return 0.0
    return math.copysign(1.0, desired) * (shaft_speed - desired)


def _design_point(
    propeller: PropellerModel, drive: PitchDrive, torque_coefficient: float | None
) -> tuple[float, float, float]:
    """Return K_Tc, K_Qc and dK_Q / d(P/D) at zero advance speed, where K_Q is ``torque_coefficient`` or the best.

    Raises
    ------
    InputError
        If no pitch ratio of the actuator has that torque coefficient.
    """
    pitch_range = (drive.min, drive.max)
    if torque_coefficient is None:
        pitch = float(optimal_maps(propeller, pitch_range).pitch_ratio(0.0))
    else:
        pitch = float(pitch_of_torque_coefficient(propeller, 0.0, torque_coefficient, pitch_range))
    K_T, K_Q = (float(k) for k in propeller.coefficients(0.0, pitch))
    # A K_Qc at an end of the range is found there but for rounding.
    if torque_coefficient is not None and abs(K_Q - torque_coefficient) > 1e-6:
        ends = thrust_pitches(propeller, pitch_range)
        least, most = (float(propeller.coefficients(0.0, end)[1]) for end in ends)
        raise InputError(
            f"drivers.torque_shaft_speed.torque_coefficient: expected {least:.4g} to {most:.4g}, which the pitch range "
            f"has at zero advance speed, found {torque_coefficient:g}"
        )
    around = np.clip([pitch - _PITCH_STEP, pitch + _PITCH_STEP], *pitch_range)
    _, torque = propeller.coefficients(0.0, around)
    return K_T, K_Q, float((torque[1] - torque[0]) / (around[1] - around[0]))
