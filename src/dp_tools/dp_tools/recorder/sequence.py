"""Lost messages, counted from the publisher's sequence numbers."""

from __future__ import annotations


class SequenceCounter:
    """Counts the gaps in the sequence numbers of one topic.

    A publisher numbers its messages one by one. The first one seen sets the start; a number that is not above the last
    is a new publisher. With several publishers at once their numbers cannot be told apart, so nothing is counted, and
    ``countable`` says so. A gap is only a suspicion until :meth:`one_publisher` has confirmed it twice: a second
    publisher may speak before the graph tells of it.
    """

    def __init__(self) -> None:
        self.lost = 0
        self.countable = True
        self._suspected = 0
        self._confirmed_once = 0
        self._last: int | None = None

    def note(self, number: int | None) -> None:
        """Take the number of the next message; None where the middleware gives none."""
        if number is None:
            self.countable = False
            return
        if self.countable and self._last is not None and number > self._last:
            self._suspected += number - self._last - 1
        self._last = number

    def one_publisher(self) -> None:
        """Confirm the gaps found so far: the graph tells of no more than one publisher."""
        self.lost += self._confirmed_once
        self._confirmed_once = self._suspected
        self._suspected = 0

    def several_publishers(self) -> None:
        """Stop counting for good, and forget the gaps that are not confirmed."""
        self.countable = False
        self._suspected = self._confirmed_once = 0
