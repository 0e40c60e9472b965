"""A row of propellers at zero advance speed (bollard pull), [Ruth] (2.17)-(2.19) and (3.8)-(3.11).

Shaft speed n is in Hz (revolutions per second), as in the sources; thrust and torque carry the sign of n.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray


class BollardPropellers:
    """A row of propellers, evaluated together.

    Parameters
    ----------
    diameter
        Propeller diameters D, shape (n,), m.
    thrust_coefficient, torque_coefficient
        K_T and K_Q at zero advance number, shape (n,).
    density
        Water density, kg/m^3.
    """

    def __init__(
        self,
        diameter: FloatArray,
        thrust_coefficient: FloatArray,
        torque_coefficient: FloatArray,
        density: float,
    ) -> None:
        self.thrust_per_speed_squared = thrust_coefficient * density * diameter**4
        self.torque_per_speed_squared = torque_coefficient * density * diameter**5
        # P = 2 pi n Q with n from (3.8) gives (3.11): P = c |T|^(3/2).
        self.power_per_thrust_3_2 = (
            2.0 * math.pi * torque_coefficient / (math.sqrt(density) * diameter * thrust_coefficient**1.5)
        )

    def thrust(self, shaft_speed: FloatArray) -> FloatArray:
        """Return thrust (N) at ``shaft_speed`` (Hz): T = K_T rho D^4 n |n|."""
        return self.thrust_per_speed_squared * shaft_speed * np.abs(shaft_speed)

    def torque(self, shaft_speed: FloatArray) -> FloatArray:
        """Return propeller torque (N m) at ``shaft_speed`` (Hz): Q = K_Q rho D^5 n |n|."""
        return self.torque_per_speed_squared * shaft_speed * np.abs(shaft_speed)

    def shaft_speed(self, thrust: FloatArray) -> FloatArray:
        """Return the shaft speed (Hz) that gives ``thrust`` (N), [Ruth] (3.8) with the sign of thrust."""
        return np.sign(thrust) * np.sqrt(np.abs(thrust) / self.thrust_per_speed_squared)

    def power(self, thrust: FloatArray) -> FloatArray:
        """Return propeller power (W) at ``thrust`` (N), [Ruth] (3.11)."""
        return self.power_per_thrust_3_2 * np.abs(thrust) ** 1.5
