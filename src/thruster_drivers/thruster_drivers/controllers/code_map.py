"""Control by integer code, [Kostenko] (7)-(8), for drives that make a torque of a code."""

from __future__ import annotations

import math

from marine_model.errors import InputError
from thruster_drivers.controllers.torque_control import FeedforwardController
from thruster_drivers.controllers.tuning import Tuning
from thruster_drivers.shaft_model import ShaftModel


class CodeMapController(FeedforwardController):
    """The code of the thrust reference at the speed of the vessel, and the torque that the drive makes of it.

    The torque stands for the drive: what is sent to a real one is the code. It is that of the drive's mechanical
    characteristic at the measured shaft speed; where the sensor is lost, that at rest.

    Raises
    ------
    InputError
        If the thruster has no drive.
    """

    needs_drive = True

    speed: float | None = None
    """m/s, of the thruster along its positive thrust, within the tables of the drive; None: the map at rest is used."""

    def __init__(self, model: ShaftModel, tuning: Tuning) -> None:
        super().__init__(model, tuning)
        if model.drive is None:
            raise InputError("controller: expected a thruster with a drive for 'code_map', found one without")
        self._drive = model.drive

    @property
    def largest_speed(self) -> float:
        """Largest speed in the tables of the drive, m/s."""
        return self._drive.speeds.largest

    def _aim(self, thrust_reference: float, shaft_speed: float) -> tuple[float, float, float]:
        """Return the torque of the code, the shaft speed of the code at rest, and the design pitch ratio."""
        drive, speed = self._drive, self.speed
        if speed is not None:
            # The tables hold for thrust along the motion. Against it their nearest is no speed.
            speed = max(0.0, speed if thrust_reference >= 0.0 else -speed)
        self.code = code = drive.code(thrust_reference, speed)
        rest = drive.rest_shaft_speed(code)
        torque = drive.torque(code, shaft_speed if math.isfinite(shaft_speed) else rest)
        return torque, rest, self._pitch.design
