"""Pitch control, [Ruth] (3.15)-(3.16)."""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray
from marine_model.propellers.optimal import pitch_of_thrust_coefficient
from thruster_drivers.controllers.controllable_pitch import controllable_pitch
from thruster_drivers.controllers.scalar_map import ScalarMap
from thruster_drivers.controllers.speed_control import SpeedController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class PitchController(SpeedController):
    """One shaft speed n_c, and the pitch ratio that gives the desired thrust with it at zero advance speed.

    Thrust for which the pitch range has no pitch ratio at n_c is made by the shaft speed at the end of the range. So
    the law is continuous in thrust. Propeller models know pitch ratios above 0 only: thrust is taken to nothing, and
    reversed, by the shaft.

    Without ``shaft_speed`` in the vessel file n_c is the speed of the largest thrust at the design pitch. The shaft is
    not asked for more than that, or n_c where it is more.
    """

    needs_pitch = True

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        propeller, drive = controllable_pitch(model)
        K_T, pitch = pitch_of_thrust_coefficient(propeller, (drive.min, drive.max))
        self._least, self._most = float(K_T[0]), float(K_T[-1])

        def pitch_at(thrust_coefficient: FloatArray) -> FloatArray:
            return np.interp(thrust_coefficient, K_T, pitch)

        def torque_at(pitch_ratio: FloatArray) -> FloatArray:
            return propeller.coefficients(0.0, pitch_ratio)[1]

        self._pitch_at = ScalarMap(pitch_at, self._least, self._most)
        self._torque_coefficient = ScalarMap(torque_at, drive.min, drive.max)
        self._pitch_min, self._pitch_max = drive.min, drive.max
        self._scale = model.density * propeller.diameter**4
        self._torque_scale = self._scale * propeller.diameter
        largest = model.shaft_speed(model.thrust_max)
        self._speed = tuning.pitch_shaft_speed or largest
        self._speed_top = max(self._speed, largest)

    def _aim(self, thrust_reference: float) -> tuple[float, float]:
        """Return n_d and g(K_Td), [Ruth] (3.16)."""
        speed = self._speed
        K_Td = thrust_reference / (self._scale * speed * speed)
        size = abs(K_Td)
        if size < self._least:
            return math.copysign(speed * math.sqrt(size / self._least), K_Td), self._pitch_min
        if size > self._most:
            return math.copysign(self._faster(size / self._most), K_Td), self._pitch_max
        return math.copysign(speed, K_Td), self._pitch_at(size)

    def _faster(self, thrust_ratio: float) -> float:
        return min(self._speed_top, self._speed * math.sqrt(thrust_ratio))

    def _load(self, desired: float, pitch_ratio: float) -> float:
        """Return the load torque (N m) with K_Q at ``pitch_ratio`` and zero advance speed."""
        propeller = self._torque_coefficient(pitch_ratio) * self._torque_scale * desired * abs(desired)
        return propeller + self._model.friction(desired)
