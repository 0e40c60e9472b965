"""Manual generalized force: the last one given, until it is too old."""

from __future__ import annotations

from dp_controller.vectors import ZERO, Triple


class Joystick:
    """Keeps the last manual force with its time, and fades it to zero when no new one comes."""

    __slots__ = ("_force", "_time")

    def __init__(self) -> None:
        self._force: Triple = ZERO
        self._time: float | None = None

    @property
    def time(self) -> float | None:
        """Time of the last manual force, s; None before the first."""
        return self._time

    def set(self, force: Triple, time: float) -> None:
        """Take over a manual generalized force (N, N, N m; body frame), given at ``time`` (s)."""
        self._force = force
        self._time = time

    def is_fresh(self, now: float, timeout: float) -> bool:
        """Return whether the last force is at most ``timeout`` (s) old; a timeout of 0 never ends."""
        if self._time is None:
            return False
        return timeout <= 0.0 or now - self._time <= timeout

    def force(self, now: float, timeout: float, fade: float) -> Triple:
        """Return the force at ``now`` (s): linearly to zero within ``fade`` (s) once the timeout has passed."""
        if self._time is None:
            return ZERO
        if self.is_fresh(now, timeout):
            return self._force
        late = now - self._time - timeout
        left = 1.0 - late / fade if late < fade else 0.0
        x, y, n = self._force
        return left * x, left * y, left * n
