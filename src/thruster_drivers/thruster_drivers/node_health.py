"""What the drivers' node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from dp_node import Alarm, Health, health_with, raised
from thruster_drivers.drivers import COMMAND_STALE, NO_COMMAND, SENSOR_LOST

_CODES = {
    NO_COMMAND: "DRIVERS-NO-COMMAND",
    COMMAND_STALE: "DRIVERS-COMMAND-STALE",
    SENSOR_LOST: "DRIVERS-SENSOR-LOST",
}


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
    """

    status: str = NO_COMMAND
    command_age: float = math.inf
    commands: int = 0
    clipped: int = 0
    last_clipped: tuple[str, ...] = ()
    feedback: int = 0
    ventilated: set[str] = field(default_factory=set)
    _reported: tuple[int, int] = (0, 0)

    def reported(self) -> None:
        """Begin the next report."""
        self._reported = (self.feedback, self.clipped)
        self.ventilated.clear()

    def fresh(self) -> tuple[int, int]:
        """Return feedbacks answered and commands clipped since the last report."""
        feedback, clipped = self._reported
        return self.feedback - feedback, self.clipped - clipped


def status_alarm(status: str) -> Alarm | None:
    """Return the alarm that a status of the core means; None if it means none."""
    return raised(_CODES[status]) if status in _CODES else None


def health_of(tally: Tally, controller: str, names: Sequence[str], events: Sequence[int] | None) -> Health:
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
    feedback, clipped = tally.fresh()
    alarms: list[Alarm] = []
    own = status_alarm(tally.status)
    if not feedback:
        alarms.append(raised("DRIVERS-NO-FEEDBACK"))
    elif own is not None:
        alarms.append(own)
    if clipped:
        alarms.append(raised("DRIVERS-COMMAND-CLIPPED", f"{clipped} times, {', '.join(tally.last_clipped)} last"))
    if tally.ventilated:
        told = [name for name in names if name in tally.ventilated]
        alarms.append(raised("DRIVERS-VENTILATION", ", ".join(told)))
    return health_with(alarms, values)
