"""What every local thruster controller does: thrust reference in, motor torque and pitch set point out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

from thruster_drivers.controllers.limits import ShaftLimits
from thruster_drivers.controllers.pitch_setpoint import PitchSetpoint
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class ControlOutput(NamedTuple):
    """What one step asks of one thruster.

    Attributes
    ----------
    torque
        Motor torque, N m, within the limits of motor and shaft.
    pitch_ratio
        Set point of P/D; the propeller's own where the pitch is fixed.
    """

    torque: float
    pitch_ratio: float


class ThrusterController(ABC):
    """Control law of one thruster. Holds its own state; time comes in as ``dt``.

    All laws hold for both signs of thrust: [Ruth] prints them for T_d >= 0, and a propeller at zero advance speed is
    taken as odd in the shaft speed.

    Parameters
    ----------
    model
        Propeller, shaft and motor.
    tuning
        Gains of this thruster.
    """

    needs_pitch = False
    """Whether the law works through a controllable pitch."""

    needs_drive = False
    """Whether the law works through a drive that takes integer codes."""

    code: int = 0
    """What the last step sends to a drive that takes integer codes; 0 from a law that sends none."""

    shaft_speed_reference: float = 0.0
    """Hz, n_d of the last step: what a law controls the shaft to, or, where it controls torque or power, the speed at
    which the thrust reference would be met, to hold the measured one against."""

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        self._model = model
        self._limits = ShaftLimits(model, tuning)
        self._pitch = PitchSetpoint(model)

    @abstractmethod
    def step(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, dt: float) -> ControlOutput:
        """Return motor torque and pitch set point.

        Parameters
        ----------
        thrust_reference
            Desired thrust T_d, N, within the thruster's limits.
        shaft_speed
            Measured n, Hz. When it is not finite the sensor is lost: the law runs open loop.
        pitch_ratio
            Measured P/D, from which the first set point moves off; when it is not finite, from the design's.
        dt
            s since the previous step, above 0.
        """

    @abstractmethod
    def take_over(self, thrust_reference: float, shaft_speed: float, pitch_ratio: float, torque: float) -> None:
        """Begin where another law left off: the next step gives ``torque`` but for what one sample changes.

        Parameters
        ----------
        thrust_reference
            T_d of the last step, N.
        shaft_speed, pitch_ratio
            Measured n, Hz, and P/D; not finite where a sensor is lost.
        torque
            Motor torque last asked for, N m.
        """
