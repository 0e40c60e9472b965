"""The speed of the vessel, as the thrusters see it whose drives take codes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from marine_model.thruster import AzimuthThruster
from marine_model.vessel import Vessel
from thruster_drivers.controllers import CodeMapController, ThrusterController


class CodeMaps:
    """Tells the laws of code the speed along their thrusters.

    The tables of a drive are over the speed of the water along its shaft. [Kostenko] takes the surge speed for it; here
    it is the surge speed's part along the thruster, V_x cos, which is what the propeller meets: 0.92 of it for one at
    22.5 deg to the vessel, nothing for one across. What the vessel does along the other axes is not told.

    Parameters
    ----------
    vessel
        Directions of the thrusters.
    controllers
        Law of every thruster.
    compensated
        False: the laws take the map at rest.
    """

    def __init__(self, vessel: Vessel, controllers: Sequence[ThrusterController], compensated: bool) -> None:
        self._compensated = compensated
        self._laws: list[tuple[int, CodeMapController, float, float, float | None]] = []
        reach = []
        for j, (thruster, law) in enumerate(zip(vessel.thrusters, controllers, strict=True)):
            if isinstance(law, CodeMapController):
                (ahead, *_), (across, *_) = thruster.plane
                turns = isinstance(thruster, AzimuthThruster)
                fixed = thruster.fixed_direction
                share = None if turns else ahead * math.cos(fixed) + across * math.sin(fixed)
                self._laws.append((j, law, ahead, across, share))
                reach.append(law.largest_speed)
        self._largest = min(reach, default=0.0)
        self.any = bool(self._laws)
        """Whether there is such a law."""
        self.lost = False
        """Whether the speed is needed and was not known at the last step."""
        self.beyond = 0.0
        """How far the last speed was outside the tables, m/s."""

    def tell(self, surge_speed: float | None, azimuth: Sequence[float]) -> None:
        """Hand on the surge speed (m/s; None or not finite: not known) at the measured azimuths (rad)."""
        if not self._compensated:
            surge_speed = None
        elif surge_speed is not None and not math.isfinite(surge_speed):
            surge_speed = None
        self.lost, self.beyond = self._compensated and surge_speed is None, 0.0
        if surge_speed is None:
            for _, law, _, _, _ in self._laws:
                law.speed = None
            return
        held = min(max(surge_speed, 0.0), self._largest)
        self.beyond = surge_speed - held
        for j, law, ahead, across, share in self._laws:
            if share is None:
                angle = azimuth[j]
                # Where the sensor is lost, as ahead: the largest part.
                share = ahead * math.cos(angle) + across * math.sin(angle) if math.isfinite(angle) else 1.0
            law.speed = max(-held, min(held, held * share))  # beyond it by rounding
