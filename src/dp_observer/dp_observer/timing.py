"""When a step came late, an estimate is too old, and how far it may be predicted: one rule for all axes."""

from __future__ import annotations

from dp_observer.settings import ObserverSettings

# A step longer than this many samples has missed one: the measurement says nothing about the time before.
LATE = 1.5

_ROUNDING = 1.0e-9  # s, of ages added up from steps


def is_too_old(age: float, settings: ObserverSettings) -> bool:
    """Return whether dead reckoning for ``age`` (s) is longer than its limit."""
    return age > settings.dead_reckoning_limit + _ROUNDING


def longest_prediction(settings: ObserverSettings, sample_time: float) -> float:
    """Return how far to predict at most (s): a longer gap ends in an invalid estimate all the same. Bounds the work."""
    return max(settings.dead_reckoning_limit, sample_time)
