"""The disturber without ROS: one pose in, none, one or several out."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from dp_tools.disturber.settings import DisturberSettings

# Beyond this many the oldest of the messages that are held back is sent: a delay must not take all memory.
_LARGEST_QUEUE = 100_000


@dataclass(frozen=True, slots=True)
class PoseSample:
    """One message of a stream of poses.

    Attributes
    ----------
    stamp
        Time stamp, ns.
    position
        North (m), east (m), heading (rad).
    payload
        What else belongs to the message; passed through.
    other_cover
        Whether the quaternion has the other sign.
    """

    stamp: int
    position: tuple[float, float, float]
    payload: object = None
    other_cover: bool = False


@dataclass(slots=True)
class DisturberCounts:
    """What was done to the messages so far."""

    received: int = 0
    sent: int = 0
    lost: int = 0
    duplicated: int = 0
    reordered: int = 0
    not_finite: int = 0


class Disturber:
    """Applies faults in a fixed order: lost, not finite, frozen, jumped, restamped, delayed, overtaken, duplicated.

    Every message draws the same count of random numbers whatever the settings are, so that one fault switched on or off
    does not change what another one hits.

    Parameters
    ----------
    settings
        Faults.
    """

    def __init__(self, settings: DisturberSettings) -> None:
        self._settings = settings
        self._random = np.random.default_rng(settings.seed)
        self._frozen: PoseSample | None = None
        self._delayed: deque[tuple[int, PoseSample]] = deque()  # due at this stamp (ns) of what comes in
        self._overtaken: PoseSample | None = None
        self.counts = DisturberCounts()

    @property
    def settings(self) -> DisturberSettings:
        """Settings in force."""
        return self._settings

    @property
    def held(self) -> int:
        """Number of messages that are still held back."""
        return len(self._delayed) + (self._overtaken is not None)

    def apply(self, settings: DisturberSettings) -> None:
        """Replace the settings from the next message on; another seed begins its own sequence."""
        if settings.seed != self._settings.seed:
            self._random = np.random.default_rng(settings.seed)
        if settings.freeze != self._settings.freeze:
            self._frozen = None
        self._settings = settings

    def step(self, sample: PoseSample) -> list[PoseSample]:
        """Return what is sent when ``sample`` comes, in order."""
        settings, counts = self._settings, self.counts
        lose, spoil, overtake, twice = self._random.random(4).tolist()
        counts.received += 1
        due: list[tuple[PoseSample, bool, bool]] = []  # sample, overtaken, twice
        if lose < settings.loss:
            counts.lost += 1
        else:
            changed = self._spoiled(sample, spoil < settings.not_finite)
            self._delayed.append((sample.stamp + round(settings.delay * 1e9), changed))
        while self._delayed and (self._delayed[0][0] <= sample.stamp or len(self._delayed) > _LARGEST_QUEUE):
            due.append((self._delayed.popleft()[1], overtake < settings.reorder, twice < settings.duplicate))
        sent: list[PoseSample] = []
        for one, is_overtaken, is_doubled in due:
            if is_overtaken and self._overtaken is None:
                self._overtaken = one
                counts.reordered += 1
                continue
            sent += [one, one] if is_doubled else [one]
            counts.duplicated += is_doubled
            if self._overtaken is not None:
                sent.append(self._overtaken)
                self._overtaken = None
        counts.sent += len(sent)
        return sent

    def _spoiled(self, sample: PoseSample, not_finite: bool) -> PoseSample:
        settings = self._settings
        if settings.freeze != "no":
            self._frozen = self._frozen or sample
            sample = replace(sample, position=self._frozen.position)
            if settings.freeze == "message":
                sample = replace(sample, stamp=self._frozen.stamp)
        jump = settings.jump
        if jump.north or jump.east or jump.heading:
            north, east, heading = sample.position
            sample = replace(sample, position=(north + jump.north, east + jump.east, heading + jump.heading))
        if settings.time_offset:
            sample = replace(sample, stamp=max(0, sample.stamp + round(settings.time_offset * 1e9)))
        if settings.other_cover:
            sample = replace(sample, other_cover=True)
        if not_finite:
            self.counts.not_finite += 1
            sample = replace(sample, position=(math.nan, math.nan, math.nan))
        return sample
