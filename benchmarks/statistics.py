"""Order statistics of repeated measurements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Summary:
    """What repetitions of one measurement show, in the unit of the measurement."""

    count: int
    median: float
    p99: float
    low: float
    high: float


def quantile(values: Sequence[float], share: float) -> float:
    """Return the value below which ``share`` of the sorted ``values`` lie, interpolated linearly between neighbours.

    Raises
    ------
    ValueError
        If there are no values, one is not finite, or ``share`` is outside 0 to 1.
    """
    if not values:
        raise ValueError("values: expected at least one, found none")
    if not all(math.isfinite(value) for value in values):
        raise ValueError("values: expected finite numbers, found one that is not")
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share: expected 0 to 1, found {share}")
    ordered = sorted(values)
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


def summarize(values: Sequence[float]) -> Summary:
    """Return median, 99th percentile and extremes. Raises ValueError as :func:`quantile`."""
    return Summary(len(values), quantile(values, 0.5), quantile(values, 0.99), min(values), max(values))
