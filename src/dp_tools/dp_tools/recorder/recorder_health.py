"""What the recorder says of itself on /diagnostics: a pure function of counts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dp_node import Alarm, Health, health_with, raised


@dataclass(frozen=True)
class RecorderState:
    """How the recording goes.

    Attributes
    ----------
    messages, size, files
        What is in the bag; the size in bytes.
    topics
        How many are recorded.
    lost
        Messages that never came, by topic.
    silent
        Nodes that did not tell their parameters.
    failed
        Why the recording stopped; empty while it goes on.
    disk_full
        Whether that was for want of space.
    """

    messages: int = 0
    topics: int = 0
    size: int = 0
    files: int = 0
    lost: Mapping[str, int] | None = None
    silent: Sequence[str] = ()
    failed: str = ""
    disk_full: bool = False


def health_of(state: RecorderState) -> Health:
    """Return level, text, values and alarms."""
    lost = state.lost or {}
    values: dict[str, object] = {
        "messages": state.messages,
        "topics": state.topics,
        "bytes": state.size,
        "files": state.files,
        "lost": sum(lost.values()),
        **{f"lost {topic}": count for topic, count in lost.items()},
    }
    alarms: list[Alarm] = []
    if state.failed:
        alarms.append(raised("RECORDER-DISK-FULL" if state.disk_full else "RECORDER-WRITE-FAILED", state.failed))
    if lost:
        alarms.append(raised("RECORDER-MESSAGES-LOST", f"on {', '.join(lost)}"))
    if state.silent:
        alarms.append(raised("RECORDER-PARAMETERS-MISSING", ", ".join(state.silent)))
    return health_with(alarms, values, "recording")
