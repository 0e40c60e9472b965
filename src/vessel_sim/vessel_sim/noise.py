"""Seeded noise in a fixed order.

Poses and thruster sensors have a stream each, so that neither shifts the other's draws. Rows are drawn in blocks
for speed, and used up whether noise is on or off: switching it changes nothing that comes later.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from marine_model.guards import FloatArray

_BLOCK = 1024

# Key of what has random numbers of its own, whoever else draws any. 0 and up are spawned by noise_streams.
OWN_STREAMS: Mapping[str, int] = {"gusts": 100, "wind_direction": 101, "wind_sensor": 102, "current": 103, "sea": 104}


class NoiseStream:
    """Rows of independent standard normal numbers, each with one uniform number.

    Parameters
    ----------
    sequence
        Seed of this stream.
    width
        Normal numbers a row.
    """

    def __init__(self, sequence: np.random.SeedSequence, width: int) -> None:
        self._generator = np.random.Generator(np.random.PCG64(sequence))
        self._width = width
        self._next = _BLOCK
        self._normal: FloatArray = np.empty((0, width))
        self._uniform: list[float] = []

    def row(self) -> tuple[FloatArray, float]:
        """Return the next normal numbers, shape (width,), and the uniform number in [0, 1) that goes with them."""
        if self._next == _BLOCK:
            self._normal = self._generator.standard_normal((_BLOCK, self._width))
            self._uniform = self._generator.random(_BLOCK).tolist()
            self._next = 0
        i = self._next
        self._next = i + 1
        return self._normal[i], self._uniform[i]


def noise_streams(seed: int, *widths: int) -> tuple[NoiseStream, ...]:
    """Return independent streams, one for each of ``widths``."""
    children = np.random.SeedSequence(seed).spawn(len(widths))
    return tuple(NoiseStream(child, width) for child, width in zip(children, widths, strict=True))


def own_stream(seed: int, what: str, width: int) -> NoiseStream:
    """Return the stream of ``what`` out of ``OWN_STREAMS``: no other stream of the run changes with it."""
    return NoiseStream(own_sequence(seed, what), width)


def generator(seed: int, what: str) -> np.random.Generator:
    """Return a new generator of the random numbers of ``what`` out of ``OWN_STREAMS``."""
    return np.random.Generator(np.random.PCG64(own_sequence(seed, what)))


def own_sequence(seed: int, what: str) -> np.random.SeedSequence:
    """Return the seed of what is in ``OWN_STREAMS``."""
    return np.random.SeedSequence(seed, spawn_key=(OWN_STREAMS[what],))
