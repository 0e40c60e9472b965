"""What a local controller knows about one thruster: propeller at zero advance speed, shaft and motor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from marine_model.vessel import Vessel


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
    """

    thrust_per_speed_squared: float
    torque_per_speed_squared: float
    inertia: float
    torque_max: float
    friction_static: float
    friction_viscous: float

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


def shaft_models(vessel: Vessel) -> tuple[ShaftModel, ...]:
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
        )
        for j, thruster in enumerate(vessel.thrusters)
    )
