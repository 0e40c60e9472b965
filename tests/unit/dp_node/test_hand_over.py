"""The last messages of publishers: each gets its turn, and all share one time."""

from __future__ import annotations

import time
from typing import Any

import pytest
from rclpy.duration import Duration

from dp_node.hand_over import hand_over


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, which goes on only while a reader is waited for."""
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


class Reader:
    """A publisher whose reader acknowledges after ``needs`` seconds."""

    def __init__(self, clock: list[float], needs: float) -> None:
        self.clock = clock
        self.needs = needs
        self.given: list[float] = []

    def wait_for_all_acked(self, patience: Duration) -> bool:
        self.given.append(patience.nanoseconds / 1e9)
        self.clock[0] += min(self.needs, self.given[-1])
        return self.needs <= self.given[-1]


def test_readers_that_acknowledge_are_waited_for(clock: list[float]) -> None:
    readers: list[Any] = [Reader(clock, needs) for needs in (0.0, 0.0625, 0.0)]
    assert hand_over(readers, patience=30.0)
    # What one reader took is not given to the next a second time.
    assert 30.0 >= readers[0].given[0] >= readers[1].given[0] >= readers[2].given[0] + 0.01


def test_a_reader_that_was_killed_costs_its_time_once(clock: list[float]) -> None:
    readers: list[Any] = [Reader(clock, needs) for needs in (1e9, 1e9, 0.0)]
    assert not hand_over(readers, patience=0.05)
    assert [len(reader.given) for reader in readers] == [1, 1, 1]
    assert [reader.given[0] for reader in readers[1:]] == [0.0, 0.0]
