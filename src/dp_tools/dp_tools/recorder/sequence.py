"""Lost messages, counted from the publisher's sequence numbers."""

from __future__ import annotations


class SequenceCounter:
    """Counts the gaps in the sequence numbers of one topic.

    A publisher numbers its messages one by one. The first one seen sets the start; a number that is not above the last
    is a new publisher. With several publishers at once their numbers cannot be told apart, so nothing is counted, and
    ``countable`` says so.
    """

    def __init__(self) -> None:
        self.lost = 0
        self.countable = True
        self._last: int | None = None

    def note(self, number: int | None) -> None:
        """Take the number of the next message; None where the middleware gives none."""
        if number is None:
            self.countable = False
            return
        if self.countable and self._last is not None and number > self._last:
            self.lost += number - self._last - 1
        self._last = number

    def several_publishers(self) -> None:
        """Stop counting for good."""
        self.countable = False
