"""How often something comes, and how fast simulated time goes."""

from __future__ import annotations

from collections import deque

# Long enough for one message a second, short enough that a stop is seen.
_WINDOW = 4.0  # s
_LEAST = 2.0  # s; less says little of what comes a few times a second


class Meter:
    """Growth of a total a second, over the last few seconds."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float]] = deque()

    def note(self, now: float, total: float) -> None:
        """Take note of the total at ``now`` (s); one that falls begins anew."""
        if self._seen and total < self._seen[-1][1]:
            self._seen.clear()
        self._seen.append((now, total))
        while len(self._seen) > 2 and now - self._seen[1][0] >= _WINDOW:
            self._seen.popleft()

    @property
    def rate(self) -> float | None:
        """Growth a second; None before there are two seconds of it."""
        if len(self._seen) < 2:
            return None
        (since, began), (until, ended) = self._seen[0], self._seen[-1]
        return (ended - began) / (until - since) if until - since >= _LEAST else None
