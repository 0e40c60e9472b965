"""Health of a node, and its form on /diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Health:
    """What a node says of itself: a level, one line of text, and values."""

    level: Level = Level.OK
    message: str = "nominal"
    values: Mapping[str, object] = field(default_factory=dict)

    def worse_of(self, other: Health) -> Health:
        """Return the worse of two, with the values of both; two of one level above OK are both told."""
        values = {**self.values, **other.values}
        if self.level == other.level and self.level is not Level.OK and self.message != other.message:
            return Health(self.level, f"{self.message}; {other.message}", values)
        worst = self if self.level >= other.level else other
        return Health(worst.level, worst.message, values)


def to_status(name: str, health: Health) -> DiagnosticStatus:
    """Return the message for a node called ``name``."""
    return DiagnosticStatus(
        level=bytes([health.level]),
        name=name,
        message=health.message,
        hardware_id="",
        values=[KeyValue(key=key, value=_text(value)) for key, value in health.values.items()],
    )


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
