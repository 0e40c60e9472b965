"""What a node keeps of messages until a demand uses them, and the demand that waits for them; without ROS.

In lockstep every run gives the same numbers, so that what a demand uses may not depend on which message was faster: a
demand at t uses the newest message from before t, and waits until that of one time step before t has come. With a time
step of 0 it waits for that of t itself.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Generic, TypeVar

T = TypeVar("T")
D = TypeVar("D")

# Messages that are kept until a demand comes.
_KEPT = 256


class Inbox(Generic[T]):
    """Stamped values of one topic, in the order in which they came.

    Parameters
    ----------
    what
        Name of what is in it, for who waits for it.
    """

    def __init__(self, what: str) -> None:
        self.what = what
        self.clear()

    def clear(self) -> None:
        """Forget all of it."""
        self._kept: deque[tuple[int, T | None]] = deque(maxlen=_KEPT)
        self._taken: int | None = None

    def __len__(self) -> int:
        """Return how many are kept."""
        return len(self._kept)

    def put(self, stamp: int, value: T | None) -> None:
        """Keep ``value`` of ``stamp`` (ns); None where the message was refused, which is an answer too."""
        self._kept.append((stamp, value))

    def reaches(self, stamp: int) -> bool:
        """Return whether the newest is of ``stamp`` (ns) or later."""
        return bool(self._kept) and self._kept[-1][0] >= stamp

    def take(self, before: int) -> tuple[int, T] | None:
        """Return stamp and value of the newest from before ``before`` (ns).

        None if there is none, it was refused, or it has been taken: what is taken once grows old with whoever has it.
        """
        for stamp, value in reversed(self._kept):
            if stamp < before:
                if value is None or stamp == self._taken:
                    return None
                self._taken = stamp
                return stamp, value
        return None


class WaitingRoom(Generic[D]):
    """Room for one demand, until the inboxes that it needs have what came a time step before it.

    Parameters
    ----------
    time_step
        How long before the demand what it needs was stamped, ns: 0 for what has its own stamp.
    """

    def __init__(self, time_step: int) -> None:
        self._time_step = time_step
        self._demand: D | None = None
        self._stamp = 0

    @property
    def holds(self) -> bool:
        """Whether a demand is waiting."""
        return self._demand is not None

    def missing(self, stamp: int, inboxes: Iterable[Inbox[T]]) -> list[str]:
        """Return what is not there yet for a demand of ``stamp`` (ns)."""
        return [inbox.what for inbox in inboxes if not inbox.reaches(stamp - self._time_step)]

    def hold(self, stamp: int, demand: D) -> None:
        """Let ``demand`` of ``stamp`` (ns) wait, in the place of one that waits already."""
        self._stamp, self._demand = stamp, demand

    def waits_for(self, inboxes: Iterable[Inbox[T]]) -> list[str]:
        """Return what the demand that is held is waiting for; empty if none is held or all is there."""
        return self.missing(self._stamp, inboxes) if self.holds else []

    def release(self, inboxes: Iterable[Inbox[T]]) -> D | None:
        """Return the demand if it has nothing more to wait for, and hold it no longer."""
        if self._demand is None or self.waits_for(inboxes):
            return None
        demand, self._demand = self._demand, None
        return demand

    def clear(self) -> None:
        """Forget the demand."""
        self._demand = None
