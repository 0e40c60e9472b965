"""What the drivers' node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from dp_node import Alarm, Health, health_with, raised
from thruster_drivers.drivers import COMMAND_STALE, NO_COMMAND, SENSOR_LOST, SPEED_LOST

_CODES = {
    NO_COMMAND: "DRIVERS-NO-COMMAND",
    COMMAND_STALE: "DRIVERS-COMMAND-STALE",
    SENSOR_LOST: "DRIVERS-SENSOR-LOST",
    SPEED_LOST: "DRIVERS-SPEED-LOST",
}

# m/s. An estimate is noisy, and a vessel that hovers is as often astern as ahead. So much outside the tables is worth
# 0.5 N of 42 N with those of [Kostenko], less than they are uncertain by.
_SPEED_TOLERANCE = 0.05


@dataclass(slots=True)
class Tally:
    """What the node has done since it was activated.

    Attributes
    ----------
    status
        Of the last step.
    command_age
        Age of the command in force at the last step, s; infinite before the first.
    commands, clipped
        Commands taken, and those of them beyond a limit of a thruster.
    last_clipped
        Names of the thrusters in the last of these.
    feedback
        Feedbacks answered.
    ventilated
        Names of the thrusters whose propellers drew air since the last report.
    speed_clamped
        Feedbacks answered with a surge speed outside the tables of a drive, clamped.
    speed_beyond
        How far the surge speed was outside since the last report, m/s: the farthest, with its sign.
    """

    status: str = NO_COMMAND
    command_age: float = math.inf
    commands: int = 0
    clipped: int = 0
    last_clipped: tuple[str, ...] = ()
    feedback: int = 0
    ventilated: set[str] = field(default_factory=set)
    speed_clamped: int = 0
    speed_beyond: float = 0.0
    _reported: tuple[int, int] = (0, 0)

    def clamped(self, beyond: float) -> None:
        """Count a surge speed that was ``beyond`` (m/s) outside the tables of a drive; 0 is inside."""
        if beyond != 0.0:
            self.speed_clamped += 1
            self.speed_beyond = max(self.speed_beyond, beyond, key=abs)

    def reported(self) -> None:
        """Begin the next report."""
        self._reported = (self.feedback, self.clipped)
        self.ventilated.clear()
        self.speed_beyond = 0.0

    def fresh(self) -> tuple[int, int]:
        """Return feedbacks answered and commands clipped since the last report."""
        feedback, clipped = self._reported
        return self.feedback - feedback, self.clipped - clipped


def status_alarm(status: str) -> Alarm | None:
    """Return the alarm that a status of the core means; None if it means none."""
    return raised(_CODES[status]) if status in _CODES else None


def health_of(
    tally: Tally,
    controller: str,
    names: Sequence[str],
    events: Sequence[int] | None,
    speed_age: float | None = None,
    waiting: str = "",
) -> Health:
    """Return level, text, values and alarms.

    Parameters
    ----------
    tally
        What was done.
    controller
        Control law in force.
    names
        Thrusters.
    events
        How often each has begun to ventilate; None while nothing is detected.
    speed_age
        Age of the surge speed in force at the last step, s, infinite before the first; None where no law looks at it.
    waiting
        What the feedback that is held is waiting for; empty if none is.
    """
    values: dict[str, object] = {
        "status": tally.status,
        "command_age_s": tally.command_age,
        "commands": tally.commands,
        "clipped_commands": tally.clipped,
        "last_clipped": " ".join(tally.last_clipped),
        "controller": controller,
        "feedback": tally.feedback,
    }
    if events is not None:
        for name, count in zip(names, events, strict=True):
            values[f"ventilation_events.{name}"] = count
    if speed_age is not None:
        values |= {"speed_age_s": speed_age, "speed_clamped": tally.speed_clamped}
    feedback, clipped = tally.fresh()
    alarms: list[Alarm] = []
    own = status_alarm(tally.status)
    if waiting:
        alarms.append(raised("DRIVERS-WAITS", waiting))
    elif not feedback:
        alarms.append(raised("DRIVERS-NO-FEEDBACK"))
    elif own is not None:
        alarms.append(own)
    if clipped:
        alarms.append(raised("DRIVERS-COMMAND-CLIPPED", f"{clipped} times, {', '.join(tally.last_clipped)} last"))
    if abs(tally.speed_beyond) > _SPEED_TOLERANCE:
        alarms.append(raised("DRIVERS-SPEED-CLAMPED", f"by up to {abs(tally.speed_beyond):.2g} m/s"))
    if tally.ventilated:
        told = [name for name in names if name in tally.ventilated]
        alarms.append(raised("DRIVERS-VENTILATION", ", ".join(told)))
    return health_with(alarms, values)
