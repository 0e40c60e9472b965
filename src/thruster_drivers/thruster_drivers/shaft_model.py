"""What a local controller knows about one thruster: propeller, shaft, motor and pitch actuator."""

from __future__ import annotations

import math
from dataclasses import dataclass

from marine_model.code_maps import CodeDrive
from marine_model.propellers.base import PropellerModel
from marine_model.propulsion import Propulsion
from marine_model.thruster import PitchDrive


@dataclass(frozen=True, slots=True)
class ShaftModel:
    """Constants of one thruster, as scalars: at four thrusters, scalar arithmetic is the fastest.

    Attributes
    ----------
    thrust_per_speed_squared
        K_Tc rho D^4, N/Hz^2, with K_Tc = K_T(J_A = 0), [Ruth] (3.4).
    torque_per_speed_squared
        K_Qc rho D^5, N m/Hz^2, with K_Qc = K_Q(J_A = 0), [Ruth] (3.5).
    inertia
        kg m^2, all that turns.
    torque_max
        N m, motor torque limit either way.
    friction_static, friction_viscous
        N m and N m/Hz: friction torque is sign(n) friction_static + friction_viscous n.
    power_max, speed_max
        W and Hz, either way; infinite where the vessel file gives none.
    thrust_max
        N, the largest thrust either way.
    density
        rho, kg/m^3.
    pitch_ratio
        P/D of the design, where K_Tc and K_Qc hold.
    propeller, pitch
        Propeller model and pitch actuator. Without an actuator the pitch is fixed.
    drive
        Maps of a drive that takes integer codes; None where there is none.
    """

    thrust_per_speed_squared: float
    torque_per_speed_squared: float
    inertia: float
    torque_max: float
    friction_static: float
    friction_viscous: float
    power_max: float = math.inf
    speed_max: float = math.inf
    thrust_max: float = math.inf
    density: float = math.nan
    pitch_ratio: float = math.nan
    propeller: PropellerModel | None = None
    pitch: PitchDrive | None = None
    drive: CodeDrive | None = None

    def shaft_speed(self, thrust: float) -> float:
        """Return the shaft speed (Hz) for ``thrust`` (N): [Ruth] (3.8), extended by the sign of thrust.

        As printed, (3.8) holds for T_d >= 0 only.
        """
        return math.copysign(math.sqrt(abs(thrust) / self.thrust_per_speed_squared), thrust)

    def thrust(self, shaft_speed: float) -> float:
        """Return the nominal thrust (N) at ``shaft_speed`` (Hz), the inverse of :meth:`shaft_speed`."""
        return self.thrust_per_speed_squared * shaft_speed * abs(shaft_speed)

    def load_torque(self, shaft_speed: float) -> float:
        """Return the motor torque (N m) that keeps ``shaft_speed`` (Hz): propeller torque and friction."""
        load = (self.torque_per_speed_squared * abs(shaft_speed) + self.friction_viscous) * shaft_speed
        if shaft_speed > 0.0:
            return load + self.friction_static
        if shaft_speed < 0.0:
            return load - self.friction_static
        return load

    def friction(self, shaft_speed: float) -> float:
        """Return the friction torque (N m) at ``shaft_speed`` (Hz)."""
        if shaft_speed > 0.0:
            return self.friction_viscous * shaft_speed + self.friction_static
        if shaft_speed < 0.0:
            return self.friction_viscous * shaft_speed - self.friction_static
        return 0.0


def shaft_models(vessel: Propulsion) -> tuple[ShaftModel, ...]:
    """Return one model per thruster, in the order of the vessel file."""
    propellers = vessel.propellers
    return tuple(
        ShaftModel(
            thrust_per_speed_squared=float(propellers.thrust_per_speed_squared[j]),
            torque_per_speed_squared=float(propellers.torque_per_speed_squared[j]),
            inertia=thruster.shaft.inertia,
            torque_max=thruster.shaft.torque_max,
            friction_static=thruster.shaft.friction_static,
            friction_viscous=thruster.shaft.friction_viscous,
            power_max=math.inf if thruster.shaft.power_max is None else thruster.shaft.power_max,
            speed_max=math.inf if thruster.shaft.speed_max is None else thruster.shaft.speed_max,
            thrust_max=max(thruster.thrust.max, -thruster.thrust.min),
            density=vessel.density,
            pitch_ratio=float(vessel.pitch_ratio[j]),
            propeller=vessel.propeller_models[j],
            pitch=thruster.pitch,
            drive=None if thruster.drive is None else thruster.drive.build(vessel.propeller_models[j], vessel.density),
        )
        for j, thruster in enumerate(vessel.thrusters)
    )
