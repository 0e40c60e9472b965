"""Time stamps as whole nanoseconds, so that differences are exact, and what is made of stamps that jump."""

from __future__ import annotations

from builtin_interfaces.msg import Time

from marine_model.errors import InputError

NANOSECONDS = 1_000_000_000

# Stamps in a row that jumped and go on from there: as many are believed.
BELIEVED = 3
# A jump by more than so many samples is no matter of messages that were late, lost or overtaken.
GAP_SAMPLES = 10


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


class SourceRestartError(InputError):
    """The source of an input began anew: what was made of its past holds no longer."""


class StampSequence:
    """Stamps of one topic, which must increase, and by no more than a gap at once.

    A stamp that repeats, lies behind or lies more than the gap ahead is refused. Where :data:`BELIEVED` of them in a
    row agree, that is increase by no more than the gap from one to the next, they are believed: those far ahead are
    the same source after a pause; those far behind are a source that began anew. Stamps behind by no more than the gap
    are refused until they have caught up: messages that were overtaken look just the same.

    Parameters
    ----------
    name
        Name of the topic, for the error text.
    sample
        Time between two messages, s. The gap is :data:`GAP_SAMPLES` times as long.
    """

    def __init__(self, name: str, sample: float) -> None:
        self._name = name
        self._gap = round(GAP_SAMPLES * sample * 1e9)
        self.last: int | None = None
        self._odd = 0  # ns, the last stamp that jumped
        self._agreeing = 0  # stamps in a row that jumped and agree
        self._jumped_far = False  # whether the first of them jumped by more than the gap

    def step(self, stamp: Time, first: float) -> float:
        """Accept the next stamp and return the time since the last one (s); ``first`` for the first.

        Raises
        ------
        SourceRestartError
            If the source began anew. The sequence is reset: the same stamp, given again, is the first.
        InputError
            If the stamp is refused; the sequence keeps its place.
        """
        now = to_nanoseconds(stamp)
        last = self.last
        if last is None:
            self.last = now
            return first
        if not last < now <= last + self._gap and not self._is_believed(now):
            if now > last:
                raise InputError(
                    f"{self._name}: expected a time stamp at most {self._gap * 1e-9:g} s after {last * 1e-9:.3f} s, "
                    f"found {now * 1e-9:.3f} s"
                )
            raise InputError(f"{self._name}: expected a time stamp after {last * 1e-9:.3f} s, found {now * 1e-9:.3f} s")
        if now < last:
            self.reset()
            raise SourceRestartError(
                f"{self._name}: its source began anew: time stamps jumped from {last * 1e-9:.3f} s "
                f"to {now * 1e-9:.3f} s and go on from there"
            )
        self.last = now
        self._agreeing = 0
        return seconds_between(last, now)

    def follow(self, stamp: Time) -> None:
        """Accept the next stamp, and the first of a source that began anew too: for who keeps nothing of its past.

        Raises
        ------
        InputError
            If the stamp is refused; the sequence keeps its place.
        """
        try:
            self.step(stamp, 0.0)
        except SourceRestartError:
            self.step(stamp, 0.0)

    def check_ahead(self, what: str, stamp: int) -> None:
        """Raise InputError if ``what`` is stamped (ns) further ahead of the last stamp than the gap.

        Taken, it would make every later one of its kind jump back.
        """
        if self.last is not None and stamp > self.last + self._gap:
            raise InputError(
                f"{what}: expected a time stamp at most {self._gap * 1e-9:g} s after that of the last {self._name}, "
                f"{self.last * 1e-9:.3f} s, found {stamp * 1e-9:.3f} s"
            )

    def _is_believed(self, now: int) -> bool:
        """Take note of a stamp that jumped; return whether enough in a row agree on a jump beyond the gap."""
        if self._agreeing and self._odd < now <= self._odd + self._gap:
            self._agreeing += 1
        else:
            self._agreeing = 1
            self._jumped_far = self.last is None or abs(now - self.last) > self._gap
        self._odd = now
        return self._jumped_far and self._agreeing >= BELIEVED

    def reset(self) -> None:
        """Forget the past: the next stamp is the first."""
        self.last = None
        self._agreeing = 0
