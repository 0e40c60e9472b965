"""Which alarms are active, since when, and which were so a moment ago."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from dp_node import ALARMS, Level

# An alarm that is over stays in sight for so long: many last for one report only.
_REMEMBERED = 60.0  # s


@dataclass(frozen=True)
class ShownAlarm:
    """An alarm of one node.

    Attributes
    ----------
    node, code, text
        As on /diagnostics.
    level, advice
        Of the table of alarms; ERROR and empty for a code that is not in it.
    since
        When it was first seen, s.
    until
        When it was first seen to be over, s; None while it is active.
    acknowledged
        Whether whoever looks on has said that he has seen it.
    """

    node: str
    code: str
    text: str
    level: Level
    advice: str
    since: float
    until: float | None = None
    acknowledged: bool = False


class AlarmLog:
    """Follows the alarms of all nodes from report to report."""

    def __init__(self) -> None:
        self._alarms: dict[tuple[str, str], ShownAlarm] = {}

    def report(self, node: str, active: Mapping[str, str], stamp: float) -> None:
        """Take note of the alarms (code: text) of ``node`` at ``stamp`` (s)."""
        for code, text in active.items():
            before = self._alarms.get((node, code))
            if before is not None and before.until is None:
                self._alarms[node, code] = replace(before, text=text)
                continue
            kind = ALARMS.get(code)
            level, advice = (Level.ERROR, "") if kind is None else (kind.level, kind.advice)
            self._alarms[node, code] = ShownAlarm(node, code, text, level, advice, stamp)
        for key, alarm in list(self._alarms.items()):
            if alarm.node == node and alarm.until is None and alarm.code not in active:
                self._alarms[key] = replace(alarm, until=stamp)
        self._forget(stamp)

    def acknowledge(self) -> None:
        """Mark all that are active as seen."""
        for key, alarm in self._alarms.items():
            if alarm.until is None:
                self._alarms[key] = replace(alarm, acknowledged=True)

    @property
    def active(self) -> list[ShownAlarm]:
        """Active ones, newest first."""
        return sorted((a for a in self._alarms.values() if a.until is None), key=lambda a: -a.since)

    def over(self, now: float) -> list[ShownAlarm]:
        """Return those that were active within the last minute, newest first."""
        gone = [a for a in self._alarms.values() if a.until is not None and now - a.until < _REMEMBERED]
        return sorted(gone, key=lambda a: -(a.until or 0.0))

    def _forget(self, now: float) -> None:
        self._alarms = {key: a for key, a in self._alarms.items() if a.until is None or now - a.until < _REMEMBERED}
