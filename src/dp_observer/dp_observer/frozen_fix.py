"""A position reference that has stopped: its stamps go on, its fix does not."""

from __future__ import annotations

from dp_observer.settings import ObserverSettings
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel


class FrozenFix:
    """Counts fixes that equal the one before to the last bit, as no reference with noise gives them.

    Parameters
    ----------
    vessel
        Says whether its references have noise: without, a vessel at rest is no fault.
    """

    def __init__(self, vessel: Vessel) -> None:
        self._noisy = vessel.measurement.position_noise > 0.0 or vessel.measurement.heading_noise > 0.0
        self._last: tuple[float, ...] | None = None
        self.count = 0

    def note(self, position: FloatArray) -> None:
        """Take note of a fix: north (m), east (m), heading (rad)."""
        now = tuple(position.tolist())
        self.count = self.count + 1 if now == self._last else 0
        self._last = now

    def is_frozen(self, settings: ObserverSettings) -> bool:
        """Return whether the fix has stood still for longer than ``settings`` allow."""
        return self._noisy and 0 < settings.frozen_count <= self.count
