"""Lockstep order: act on sample k only once the allocator's answer to sample k-1 is here."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable


class AnswerGate:
    """Holds actions back until the answer to the action before has arrived.

    Two topics have no order between them: without a gate, the next sample may overtake the answer to the last, and
    the run would depend on the scheduler. An open gate (``synchronous`` false) lets every action through at once.

    Parameters
    ----------
    synchronous
        True to hold actions back.
    """

    def __init__(self, synchronous: bool) -> None:
        self.synchronous = synchronous
        self._waiting: deque[tuple[int, Callable[[], None]]] = deque()
        self._expected: int | None = None
        self._answered: int | None = None

    def submit(self, stamp: int, action: Callable[[], None]) -> None:
        """Run ``action`` for the sample at ``stamp`` (ns) now, or as soon as its turn comes."""
        if not self.synchronous:
            action()
            return
        self._waiting.append((stamp, action))
        self._release()

    def answer(self, stamp: int) -> None:
        """Take note of the answer to the sample at ``stamp`` (ns)."""
        if self._answered is None or stamp > self._answered:
            self._answered = stamp
        self._release()

    @property
    def held(self) -> int:
        """Number of actions held back."""
        return len(self._waiting)

    def _release(self) -> None:
        while self._waiting and self._is_open():
            stamp, action = self._waiting.popleft()
            self._expected = stamp
            action()

    def _is_open(self) -> bool:
        if self._expected is None:
            return True
        return self._answered is not None and self._answered >= self._expected
