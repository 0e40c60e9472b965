"""Numbers that wander about zero: first-order Gauss-Markov processes of unit variance."""

from __future__ import annotations

import math

from vessel_sim.noise import own_stream


class SlowVariation:
    """x' = -x / T + white noise, of standard deviation 1, sampled exactly.

    x(t + dt) = a x(t) + sqrt(1 - a^2) w with a = exp(-dt / T), whatever dt is. It begins as it goes on, with a number
    of standard deviation 1.

    Parameters
    ----------
    seed
        Of the run.
    what
        Name of its random numbers in :data:`vessel_sim.noise.OWN_STREAMS`.
    width
        How many independent processes.
    """

    def __init__(self, seed: int, what: str, width: int) -> None:
        self._noise = own_stream(seed, what, width)
        self.values: list[float] = self._noise.row()[0].tolist()

    def advance(self, dt: float, time_constant: float) -> None:
        """Let ``dt`` (s) pass with T = ``time_constant`` (s)."""
        kept = math.exp(-dt / time_constant)
        new = math.sqrt(-math.expm1(-2.0 * dt / time_constant))
        noise = self._noise.row()[0].tolist()
        self.values = [kept * value + new * w for value, w in zip(self.values, noise, strict=True)]
