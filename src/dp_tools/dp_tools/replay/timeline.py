"""Bag time against wall time."""

from __future__ import annotations

from marine_model.errors import InputError


class Timeline:
    """Goes on with the wall clock at a rate, or stands.

    Deadlines are worked out from one fixed pair of times, so that errors of single waits do not add up.

    Parameters
    ----------
    bag_time
        Where to begin, ns.
    now
        Wall time, ns; any zero will do.
    rate
        Bag seconds a wall second, above 0.
    paused
        True to stand at first.
    """

    def __init__(self, bag_time: int, now: int, rate: float = 1.0, paused: bool = False) -> None:
        self._bag = bag_time
        self._wall = now
        self._rate = _checked(rate)
        self._paused = paused

    @property
    def rate(self) -> float:
        """Bag seconds a wall second."""
        return self._rate

    @property
    def paused(self) -> bool:
        """Whether bag time stands."""
        return self._paused

    def at(self, now: int) -> int:
        """Return bag time, ns."""
        return self._bag if self._paused else self._bag + round((now - self._wall) * self._rate)

    def due(self, bag_time: int) -> int:
        """Return the wall time at which bag time is ``bag_time``, if it goes on like this."""
        return self._wall + round((bag_time - self._bag) / self._rate)

    def pause(self, now: int) -> None:
        """Stand from now on."""
        self._bag, self._wall, self._paused = self.at(now), now, True

    def resume(self, now: int) -> None:
        """Go on from where it stands."""
        self._bag, self._wall, self._paused = self.at(now), now, False

    def set_rate(self, rate: float, now: int) -> None:
        """Go on faster or slower from now on. Raises InputError if ``rate`` is not above 0."""
        checked = _checked(rate)
        self._bag, self._wall, self._rate = self.at(now), now, checked

    def jump(self, bag_time: int, wall: int) -> None:
        """Be at ``bag_time`` at wall time ``wall``."""
        self._bag, self._wall = bag_time, wall


def _checked(rate: float) -> float:
    if not 0.0 < rate < float("inf"):
        raise InputError(f"rate: expected a number above 0, found {rate:g}")
    return rate
