"""Time stamps as whole nanoseconds, so that differences are exact."""

from __future__ import annotations

from builtin_interfaces.msg import Time

from marine_model.errors import InputError

NANOSECONDS = 1_000_000_000


def to_nanoseconds(stamp: Time) -> int:
    """Return a stamp as nanoseconds."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def from_nanoseconds(nanoseconds: int) -> Time:
    """Return nanoseconds as a stamp."""
    sec, nanosec = divmod(nanoseconds, NANOSECONDS)
    return Time(sec=sec, nanosec=nanosec)


def seconds_between(earlier: int, later: int) -> float:
    """Return the time from ``earlier`` to ``later`` (ns) in s."""
    return (later - earlier) * 1e-9


class StampSequence:
    """Stamps of one topic, which must increase.

    Parameters
    ----------
    name
        Name of the topic, for the error text.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self.last: int | None = None

    def step(self, stamp: Time, first: float) -> float:
        """Accept the next stamp and return the time since the last one (s); ``first`` for the first.

        Raises
        ------
        InputError
            If the stamp repeats or jumps back; the sequence keeps its place.
        """
        now = to_nanoseconds(stamp)
        if self.last is None:
            self.last = now
            return first
        if now <= self.last:
            raise InputError(
                f"{self._name}: expected a time stamp after {self.last * 1e-9:.3f} s, found {now * 1e-9:.3f} s"
            )
        elapsed = seconds_between(self.last, now)
        self.last = now
        return elapsed

    def reset(self) -> None:
        """Forget the past: the next stamp is the first."""
        self.last = None
