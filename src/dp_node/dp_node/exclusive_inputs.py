"""All inputs of a node that have one publisher by design, and what is to be said of those who come to them."""

from __future__ import annotations

from collections.abc import Callable

from dp_node.alarms import Alarm, raised
from dp_node.exclusive import ExclusiveInput, Peer


class ExclusiveInputs:
    """Keeps one :class:`ExclusiveInput` a topic.

    Parameters
    ----------
    refuses
        True where messages of a second publisher are refused, false where it is only told.
    """

    def __init__(self, refuses: bool) -> None:
        self.refuses = refuses
        self._guards: dict[str, ExclusiveInput] = {}
        self._reported = 0

    def add(
        self, topic: str, count: Callable[[], int], peers: Callable[[], list[Peer]], patience: int
    ) -> Callable[[int, int], bool]:
        """Return what says whether message ``number``, received at a time (ns), is to be taken; see ExclusiveInput."""
        guard = self._guards[topic] = ExclusiveInput(count, peers, patience)
        return lambda number, now: guard.passes(number, now) or not self.refuses

    def clear(self) -> None:
        """Forget all of them: their topics are given back."""
        self._guards.clear()
        self._reported = 0

    @property
    def refused(self) -> int:
        """Messages that were not the established publishers'."""
        return sum(guard.refused for guard in self._guards.values())

    def report(self) -> list[Alarm]:
        """Return an alarm for every topic with a publisher too many, and begin the next report."""
        refused = self.refused
        sending, self._reported = refused > self._reported, refused
        found = []
        for topic, guard in self._guards.items():
            intruders = guard.intruders()
            if not intruders and not (sending and guard.refused):
                continue
            text = f"{topic}, from {', '.join([guard.established or 'unknown', *intruders])}"
            if guard.undistinguished:
                text += ", which cannot be told apart: all are refused" if self.refuses else ""
            elif self.refuses:
                text += f"; heard is {guard.established or 'who came first'}, of others {guard.refused} were refused"
            found.append(raised("NODE-SECOND-PUBLISHER", text))
        return found
