"""The table of limits: what vessel and settings allow every thruster, before supervisors have their say."""

from __future__ import annotations

import numpy as np

from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import Limit
from thrust_allocator.settings import AllocatorSettings


def limit_table(vessel: Vessel, settings: AllocatorSettings) -> FloatArray:
    """Return the limits of every thruster under ``settings``, shape (n, 14), see :class:`phase.Limit`."""
    n = len(vessel.thrusters)
    table = np.zeros((n, Limit.COLUMNS))
    span = vessel.thrust_max - vessel.thrust_min
    scale = np.array(settings.thrust_limit_scale or (1.0,) * n)
    turning = np.array(settings.azimuth_enabled or (True,) * n)
    table[:, Limit.ENABLED] = settings.enabled(vessel)
    # A thruster whose azimuth rate is scaled to nothing is one that cannot turn.
    rate = vessel.azimuth_rate * np.array(settings.azimuth_rate_scale or (1.0,) * n)
    table[:, Limit.MAY_ROTATE] = np.array(vessel.can_rotate) & turning & (rate > 0.0)
    table[:, Limit.ROTATING] = settings.azimuth_mode in ("rotating", "variable")
    table[:, Limit.THRUST_MIN] = scale * vessel.thrust_min
    table[:, Limit.THRUST_MAX] = scale * vessel.thrust_max
    table[:, Limit.THRUST_RATE] = vessel.thrust_rate
    table[:, Limit.AZIMUTH_RATE] = rate
    table[:, Limit.DIRECTION] = [wrap_angle(angle) for angle in _fixed_directions(vessel, settings).tolist()]
    table[:, Limit.ZERO_THRUST] = vessel.allocator.zero_region * span
    table[:, Limit.SPAN] = span
    table[:, Limit.REACH_LOW] = -np.inf
    table[:, Limit.REACH_HIGH] = np.inf
    table[:, Limit.FACTOR] = 1.0
    return table


def _fixed_directions(vessel: Vessel, settings: AllocatorSettings) -> FloatArray:
    """Return where every thruster points when held fixed, shape (n,), rad."""
    if not settings.fixed_direction:
        return vessel.fixed_direction
    return np.where(vessel.can_rotate, np.array(settings.fixed_direction), vessel.fixed_direction)


class Feathering:
    """Lets the thrust limits of a thruster that is enabled again grow from nothing.

    Parameters
    ----------
    n
        Number of thrusters.
    """

    def __init__(self, n: int) -> None:
        self._share = np.ones(n)
        self._enabled = np.ones(n)
        self._thrust = np.zeros((n, 2))
        self.active = False

    def reset(self) -> None:
        """Let every thruster have its full limits at once."""
        self._share[:] = 1.0
        self.active = False

    def apply(self, limits: FloatArray, time: float) -> None:
        """Take new limits, shape (n, 14), and the time (s) that a thruster takes to come back; 0 for none."""
        enabled = limits[:, Limit.ENABLED]
        if time > 0.0:
            self._share[(enabled != 0.0) & (self._enabled == 0.0)] = 0.0
            self._rate = 1.0 / time
        else:
            self._share[:] = 1.0
        self._enabled = enabled.copy()
        self._thrust[:] = limits[:, [Limit.THRUST_MIN, Limit.THRUST_MAX]]
        self.active = bool((self._share < 1.0).any())

    def step(self, limits: FloatArray, dt: float) -> None:
        """Write the limits of a step of ``dt`` (s) into ``limits``."""
        self._share = np.minimum(self._share + self._rate * dt * self._enabled, 1.0)
        limits[:, [Limit.THRUST_MIN, Limit.THRUST_MAX]] = self._share[:, None] * self._thrust
        self.active = bool((self._share < 1.0).any())
