"""Health of a node, and its form on /diagnostics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from dp_node.alarms import Alarm
from dp_node.level import Level

__all__ = ["ALARM_KEY", "Health", "Level", "health_with", "to_status"]

# Before the code of an active alarm: the key under which its text stands on /diagnostics.
ALARM_KEY = "alarm."


@dataclass(frozen=True)
class Health:
    """What a node says of itself: a level, one line of text, values, and the alarms that are active."""

    level: Level = Level.OK
    message: str = "nominal"
    values: Mapping[str, object] = field(default_factory=dict)
    alarms: tuple[Alarm, ...] = ()

    def worse_of(self, other: Health) -> Health:
        """Return the worse of two, with values and alarms of both; two of one level above OK are both told."""
        values = {**self.values, **other.values}
        alarms = (*self.alarms, *(alarm for alarm in other.alarms if alarm not in self.alarms))
        if self.level == other.level and self.level is not Level.OK and self.message != other.message:
            return Health(self.level, f"{self.message}; {other.message}", values, alarms)
        worst = self if self.level >= other.level else other
        return Health(worst.level, worst.message, values, alarms)


def health_with(alarms: Iterable[Alarm], values: Mapping[str, object] | None = None, calm: str = "nominal") -> Health:
    """Return the health of who has these alarms active: the worst level, and the texts in the order given.

    Parameters
    ----------
    alarms
        Active alarms.
    values
        Key values.
    calm
        Text while no alarm is active.
    """
    active = tuple(alarms)
    level = max((alarm.kind.level for alarm in active), default=Level.OK)
    return Health(level, "; ".join(alarm.text for alarm in active) or calm, values or {}, active)


def to_status(name: str, health: Health) -> DiagnosticStatus:
    """Return the message for a node called ``name``; two alarms of one code share a key."""
    values = {key: _text(value) for key, value in health.values.items()}
    for alarm in health.alarms:
        key = ALARM_KEY + alarm.kind.code
        values[key] = f"{values[key]}; {alarm.text}" if key in values else alarm.text
    return DiagnosticStatus(
        level=bytes([health.level]),
        name=name,
        message=health.message,
        hardware_id="",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
