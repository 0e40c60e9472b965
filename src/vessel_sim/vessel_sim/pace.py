"""Simulated time against wall time; the wall clock comes in as an argument."""

from __future__ import annotations

# Behind by more than this (wall time), the debt is forgotten: paying it back would only make the next step later.
_LARGEST_DEBT = 0.5  # s
# The achieved rate is taken over windows of this length.
_WINDOW = 2.0  # s


class Pace:
    """Says how far simulated time may have come.

    Parameters
    ----------
    rate
        Simulated seconds a wall second; 0 for no limit.
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.forgiven = 0.0  # s of wall time that could not be kept up with
        self._wall = 0.0
        self._simulated = 0.0
        self._window: tuple[float, float] | None = None
        self._achieved: float | None = None

    def restart(self, wall: float, simulated: float) -> None:
        """Begin anew from here: at the start, after a hold, after a change of rate."""
        self._wall, self._simulated = wall, simulated
        self._window = (wall, simulated)
        self._achieved = None

    def allows(self, wall: float, simulated: float) -> bool:
        """Return whether the step that begins at ``simulated`` (s) may be taken at ``wall`` (s)."""
        # A nanosecond of simulated time: stamps have no finer grain, sums of floats do.
        return self.rate == 0.0 or simulated - self._simulated <= (wall - self._wall) * self.rate + 1e-9

    def note(self, wall: float, simulated: float) -> None:
        """Take note of where the simulator is: measure the rate, and forgive a debt that is too large."""
        if self._window is None:
            self.restart(wall, simulated)
            return
        since, began = self._window
        if wall - since >= _WINDOW:
            self._achieved = (simulated - began) / (wall - since)
            self._window = (wall, simulated)
        if self.rate > 0.0:
            debt = wall - self._wall - (simulated - self._simulated) / self.rate
            if debt > _LARGEST_DEBT:
                self.forgiven += debt
                self._wall, self._simulated = wall, simulated

    @property
    def achieved(self) -> float | None:
        """Simulated seconds a wall second over the last window; None before the first is over."""
        return self._achieved
