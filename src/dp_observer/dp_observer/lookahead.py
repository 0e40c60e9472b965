"""Estimates for samples whose fix has not come: made ahead of it, and taken back should it come after all."""

from __future__ import annotations

from dp_observer.estimate import ObserverEstimate, ObserverInputs
from dp_observer.observer import Observer


class Lookahead:
    """Keeps an observer at the last message, and a twin of it that runs ahead while no message comes.

    Parameters
    ----------
    observer
        The observer that takes the measurements.
    sample
        Time between samples, ns.
    """

    def __init__(self, observer: Observer, sample: int) -> None:
        self._observer = observer
        self._sample = sample
        self._stamp: int | None = None  # ns, of the observer
        self._ahead: Observer | None = None
        self._ahead_stamp = 0  # ns, of the twin

    @property
    def stamp(self) -> int | None:
        """Stamp (ns) of the newest estimate, made ahead or not; None before the first."""
        return self._stamp if self._ahead is None else self._ahead_stamp

    def measure(self, inputs: ObserverInputs, stamp: int) -> ObserverEstimate:
        """Return the estimate for a message at ``stamp`` (ns), later than that of the message before.

        If the message is later than the twin is, the twin's way is the better one: it has seen each thrust at its
        time. If not, the twin was rash, and is forgotten. Raises InputError as ``Observer.step`` does.
        """
        observer, since = self._observer, self._stamp
        if self._ahead is not None and stamp > self._ahead_stamp:
            observer, since = self._ahead, self._ahead_stamp
        dt = (self._sample if since is None else stamp - since) * 1e-9
        estimate = observer.step(inputs, dt)
        self._observer, self._stamp, self._ahead = observer, stamp, None
        return estimate

    def run_ahead(self, inputs: ObserverInputs) -> tuple[ObserverEstimate, int] | None:
        """Return the estimate one sample on from the newest, and its stamp; None before any message.

        ``inputs`` has no fix.
        """
        if self._stamp is None:
            return None
        if self._ahead is None:
            self._ahead, self._ahead_stamp = self._observer.fork(), self._stamp
        self._ahead_stamp += self._sample
        return self._ahead.step(inputs, self._sample * 1e-9), self._ahead_stamp

    def observers(self) -> list[Observer]:
        """Return all observers at work, for new settings."""
        return [self._observer] if self._ahead is None else [self._observer, self._ahead]
