"""What the laws need that work through the pitch."""

from __future__ import annotations

import math

from marine_model.errors import InputError
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.optimal import TAU_MAX, optimal_maps
from marine_model.thruster import PitchDrive
from thruster_drivers.controllers.scalar_map import ScalarMap
from thruster_drivers.shaft_model import ShaftModel


def controllable_pitch(model: ShaftModel) -> tuple[PropellerModel, PitchDrive]:
    """Return propeller and pitch actuator. Raises InputError if the pitch is fixed."""
    if model.propeller is None or model.pitch is None:
        raise InputError("pitch: expected a controllable-pitch propeller, found a fixed pitch")
    return model.propeller, model.pitch


class OptimalSetpoints:
    """The best pitch ratio, and torque and shaft speed with it, for a thrust at an assumed advance speed.

    tau is taken at the desired thrust, tau_d = sqrt(rho) D V_A / sqrt(T_d), [Ruth] (2.31): what a driver does not
    measure is thrust. The advance speed counts along positive thrust; for thrust astern it is left out, since
    propeller data for that quadrant are rare.

    Parameters
    ----------
    model
        Thruster with a controllable pitch.
    advance_speed
        V_A, m/s, not below 0.

    Raises
    ------
    InputError
        If the pitch is fixed.
    """

    def __init__(self, model: ShaftModel, advance_speed: float) -> None:
        propeller, drive = controllable_pitch(model)
        maps = optimal_maps(propeller, (drive.min, drive.max))
        diameter, density = propeller.diameter, model.density
        self._tau_scale = math.sqrt(density) * diameter * advance_speed
        self._speed_scale = 1.0 / (math.sqrt(density) * diameter**2)
        self._torque_scale = diameter
        self._pitch_at = ScalarMap(maps.pitch_ratio, 0.0, TAU_MAX)
        self._torque_at = ScalarMap(maps.torque_per_thrust, 0.0, TAU_MAX)
        self._speed_at = ScalarMap(maps.speed, 0.0, TAU_MAX)
        self._at_rest = self._pitch_at(0.0), self._torque_at(0.0), self._speed_at(0.0)

    def at(self, thrust: float) -> tuple[float, float, float]:
        """Return pitch ratio k(tau), torque h(tau) D T_d, N m, and shaft speed m(tau) sqrt(T_d / rho) / D^2, Hz."""
        size = abs(thrust)
        if thrust > 0.0 and self._tau_scale > 0.0:
            tau = self._tau_scale / math.sqrt(thrust)
            pitch, torque_per_thrust, speed = self._pitch_at(tau), self._torque_at(tau), self._speed_at(tau)
        else:
            pitch, torque_per_thrust, speed = self._at_rest
        n = math.copysign(speed * self._speed_scale * math.sqrt(size), thrust)
        return pitch, torque_per_thrust * self._torque_scale * thrust, n
