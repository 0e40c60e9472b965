"""What the controller's node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

import math
from dataclasses import dataclass

from dp_controller.controller import (
    ESTIMATE_LATE,
    JOYSTICK_STALE,
    NOMINAL,
    OBSERVER_INVALID,
    PATH_MISSING,
    WIND_STALE,
)
from dp_controller.settings import ControllerSettings
from dp_node import Alarm, Health, health_with, raised

_CODES = {
    OBSERVER_INVALID: "CONTROLLER-OBSERVER-INVALID",
    ESTIMATE_LATE: "CONTROLLER-ESTIMATE-LATE",
    JOYSTICK_STALE: "CONTROLLER-JOYSTICK-STALE",
    PATH_MISSING: "CONTROLLER-PATH-MISSING",
    WIND_STALE: "CONTROLLER-WIND-STALE",
}


@dataclass(slots=True)
class Tally:
    """What the node has done since it was activated.

    Attributes
    ----------
    status
        Of the last sample: nominal, or the safe states in force with commas between.
    answer
        Answer to the last operator input.
    error
        Reference minus estimate at the last sample, body frame: m, m, rad; 0 in axes that are not automatic.
    below
        The same in depth (m), roll, pitch (rad) of a submerged vehicle; None on the surface.
    samples, unanswered
        Samples, and those of them without the allocator's answer to the sample before.
    late
        Whether a sample came late since the last report.
    held
        Samples that wait for the allocator or the wind.
    """

    status: str = NOMINAL
    answer: str = ""
    error: tuple[float, float, float] = (0.0, 0.0, 0.0)
    below: list[float] | None = None
    samples: int = 0
    unanswered: int = 0
    late: bool = False
    held: int = 0
    _reported: tuple[int, int] = (0, 0)

    def fresh(self) -> tuple[int, int]:
        """Return samples and unanswered ones since the last report."""
        samples, unanswered = self._reported
        return self.samples - samples, self.unanswered - unanswered

    def acted(self, status: str, error: tuple[float, float, float], below: list[float] | None = None) -> None:
        """Take note of a sample."""
        self.samples += 1
        self.status, self.error, self.below = status, error, below
        self.late = self.late or ESTIMATE_LATE in status

    def reported(self) -> None:
        """Begin the next report."""
        self._reported = (self.samples, self.unanswered)
        self.late = False


def health_of(tally: Tally, settings: ControllerSettings, waiting: str = "") -> Health:
    """Return level, text, values and alarms.

    Parameters
    ----------
    tally
        What was done.
    settings
        Those in force.
    waiting
        Input that an odometry waits for; empty if none does.
    """
    off = math.hypot(tally.error[0], tally.error[1])
    values: dict[str, object] = {
        "mode": settings.mode,
        "status": tally.status,
        "answer": tally.answer,
        "samples": tally.samples,
        "samples_without_tau_achieved": tally.unanswered,
        "odometry_held": tally.held,
        "position_error_m": off,
        "heading_error_rad": tally.error[2],
    }
    if tally.below is not None:
        values |= dict(zip(("depth_error_m", "roll_error_rad", "pitch_error_rad"), tally.below, strict=True))
    samples, unanswered = tally.fresh()
    alarms: list[Alarm] = []
    if waiting:
        alarms.append(raised("CONTROLLER-WAITS", waiting))
    elif not samples:
        alarms.append(raised("CONTROLLER-NO-ODOMETRY"))
    states = tally.status.split(",")
    alarms += [raised(_CODES[state]) for state in states if state in _CODES]
    if tally.late and ESTIMATE_LATE not in states:
        alarms.append(raised(_CODES[ESTIMATE_LATE]))
    if unanswered and unanswered >= samples:
        alarms.append(raised("CONTROLLER-NO-TAU-ACHIEVED", f"{unanswered} samples"))
    if 0.0 < settings.position_alarm < off:
        alarms.append(raised("CONTROLLER-POSITION-ERROR", f"{off:.3g} m of {settings.position_alarm:.3g} m"))
    if 0.0 < settings.heading_alarm < abs(tally.error[2]):
        detail = f"{abs(tally.error[2]):.3g} rad of {settings.heading_alarm:.3g} rad"
        alarms.append(raised("CONTROLLER-HEADING-ERROR", detail))
    if tally.below is not None and 0.0 < settings.vertical.depth_alarm < abs(tally.below[0]):
        detail = f"{abs(tally.below[0]):.3g} m of {settings.vertical.depth_alarm:.3g} m"
        alarms.append(raised("CONTROLLER-DEPTH-ERROR", detail))
    return health_with(alarms, values)
