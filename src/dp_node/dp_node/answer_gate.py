"""Lockstep order: act on sample k only once the allocator's answer to sample k-1 is here."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from marine_model.errors import InputError

# Actions that are held back. A ring in lockstep has one sample under way; some more come when it is started.
_HELD = 64


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
        self._answers: deque[int] = deque(maxlen=_HELD)

    def submit(self, stamp: int, action: Callable[[], None]) -> None:
        """Run ``action`` for the sample at ``stamp`` (ns) now, or as soon as its turn comes.

        Raises
        ------
        InputError
            If 64 are held back already, for want of an answer: the oldest of them keep their turn.
        """
        if not self.synchronous:
            action()
            return
        if len(self._waiting) >= _HELD:
            raise InputError(
                f"lockstep: expected an answer to the sample at {(self._expected or 0) * 1e-9:.3f} s, "
                f"found none while {_HELD} samples wait for it; that at {stamp * 1e-9:.3f} s is refused"
            )
        self._waiting.append((stamp, action))
        self._release()

    def answer(self, stamp: int) -> None:
        """Take note of the answer to the sample at ``stamp`` (ns).

        It opens the gate to the samples up to its own: one to a sample that has not come yet opens nothing before that.
        """
        if self.synchronous:
            self._answers.append(stamp)
            self._release()

    @property
    def held(self) -> int:
        """Number of actions held back."""
        return len(self._waiting)

    def _release(self) -> None:
        while self._waiting and self._is_open():
            stamp, action = self._waiting.popleft()
            self._expected = stamp
            while self._answers and self._answers[0] < stamp:
                self._answers.popleft()
            action()

    def _is_open(self) -> bool:
        expected = self._expected
        if expected is None:
            return True
        newest = self._waiting[-1][0]
        return any(expected <= answer <= newest for answer in self._answers)
