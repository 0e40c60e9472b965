"""How well the maps of a drive agree: thrust to code to thrust."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from marine_model.code_maps.drive import CodeDrive
from marine_model.guards import FloatArray


@dataclass(frozen=True)
class RoundTrip:
    """Thrust of the code of a thrust, at one speed; arrays have shape (k,).

    Attributes
    ----------
    thrust
        What was asked for, N.
    smooth, whole
        Thrust that comes of it less what was asked for, N: with the code as the map gives it, no further than the
        largest, and with the whole code that is sent.
    """

    thrust: FloatArray
    smooth: FloatArray
    whole: FloatArray


def round_trip(drive: CodeDrive, speed: float | None, astern: bool = False, points: int = 2000) -> RoundTrip:
    """Send thrusts from above the dead zone to the largest through (8) and (4), at rest (None) through (7) and (4).

    Parameters
    ----------
    drive
        The maps.
    speed
        m/s, inside the tables; None for the map at rest.
    astern
        True for thrust astern.
    points
        How many thrusts, equally far apart.

    Raises
    ------
    InputError
        If the speed is outside the tables.
    """
    back, there = drive.thrust_from_code, drive.code_from_thrust if speed is not None else drive.rest_code_from_thrust
    largest = drive.rest_code_from_thrust.thrust_max if speed is None else drive.code_from_thrust.thrust_max(speed)
    thrust = np.linspace(there.dead_zone, largest, points + 1)[1:] * (-1.0 if astern else 1.0)
    limit, at = float(drive.code_max), 0.0 if speed is None else speed
    smooth, whole = [], []
    for T in thrust.tolist():
        code = drive.rest_code_from_thrust.at(T) if speed is None else drive.code_from_thrust.at(T, speed)
        smooth.append(back.at(max(-limit, min(limit, code)), at) - T)
        whole.append(back.thrust(drive.code(T, speed), at) - T)
    return RoundTrip(thrust, np.array(smooth), np.array(whole))
