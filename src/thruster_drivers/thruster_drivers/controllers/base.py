"""What every local thruster controller does: thrust reference in, motor torque out."""

from __future__ import annotations

from abc import ABC, abstractmethod


class ThrusterController(ABC):
    """Control law of one thruster. Holds its own state; time comes in as ``dt``."""

    shaft_speed_reference: float = 0.0
    """Hz, n_d of the last step."""

    @abstractmethod
    def step(self, thrust_reference: float, shaft_speed: float, dt: float) -> float:
        """Return the motor torque, N m, within the motor's limit.

        Parameters
        ----------
        thrust_reference
            Desired thrust T_d, N, within the thruster's limits.
        shaft_speed
            Measured n, Hz. When it is not finite the sensor is lost: the law runs open loop.
        dt
            s since the previous step, above 0.
        """
