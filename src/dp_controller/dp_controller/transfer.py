"""Bumpless transfer: what would be a step of the demand fades instead."""

from __future__ import annotations


class Transfer:
    """A force added in one axis, which goes linearly to zero.

    At a switch it is started with the demand before minus the demand after it, so that the sum is continuous.
    """

    __slots__ = ("_left", "_start", "_time")

    def __init__(self) -> None:
        self._start = 0.0
        self._time = 0.0
        self._left = 0.0

    def begin(self, force: float, time: float) -> None:
        """Start anew from ``force`` (N or N m), to be zero after ``time`` (s); at once if that is 0."""
        self._start = force if time > 0.0 else 0.0
        self._time = self._left = time

    def advance(self, dt: float) -> None:
        """Let ``dt`` (s) pass."""
        self._left = max(0.0, self._left - dt)

    @property
    def force(self) -> float:
        """Force now, N or N m."""
        return self._start * self._left / self._time if self._left > 0.0 else 0.0
