"""Which position fixes may be used: refuse a jump, but believe one that stays."""

from __future__ import annotations

import math
from enum import Enum, auto

from dp_observer.settings import ObserverSettings
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray


class Verdict(Enum):
    """What to do with a fix."""

    USE = auto()
    REFUSE = auto()
    RESTART = auto()  # set the position to it


class MeasurementGate:
    """Judges fixes by their distance from the prediction.

    Parameters
    ----------
    hull_length
        Length (m) in which ``ObserverSettings.innovation_limit`` counts.
    """

    def __init__(self, hull_length: float) -> None:
        self._hull_length = hull_length
        self._refused: tuple[float, float, float] | None = None
        self._count = 0

    @property
    def count(self) -> int:
        """How many fixes in a row have been refused that agree with one another; 1 for the first."""
        return self._count

    def judge(self, fix: FloatArray, innovation: FloatArray, lost: bool, settings: ObserverSettings) -> Verdict:
        """Return what to do with ``fix``, shape (3,), that lies ``innovation``, shape (3,), from the prediction.

        ``lost`` says that the prediction is too old to judge by: any fix is then taken, and the position restarts
        from one that is beyond the limit.
        """
        if self._near(float(innovation[0]), float(innovation[1]), float(innovation[2]), settings):
            self._refused = None
            return Verdict.USE
        north, east, heading = fix.tolist()
        last = self._refused
        agrees = last is not None and self._near(
            north - last[0], east - last[1], wrap_angle(heading - last[2]), settings
        )
        self._count = self._count + 1 if agrees else 1
        self._refused = (north, east, heading)
        # The count-th fix in a row is no outlier any more: it is where the vessel is.
        if lost or self._count > settings.reacceptance_count:
            self._refused = None
            return Verdict.RESTART
        return Verdict.REFUSE

    def _near(self, north: float, east: float, heading: float, settings: ObserverSettings) -> bool:
        return (
            math.hypot(north, east) <= settings.innovation_limit * self._hull_length
            and abs(heading) <= settings.heading_innovation_limit
        )
