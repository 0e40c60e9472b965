"""Hops through two lines: blocks in turn, each line with its own requests, the warm-up not counted."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from itertools import count

import pytest

from benchmarks.hop import hop_results, hops_in_turn

WARM_UP = 20


class Watched:
    """Stands for the operator: looks after the processes once a block."""

    blocks = 0

    def watch(self) -> None:
        self.blocks += 1


class Line:
    """Answers request k after k us."""

    def __init__(self, name: str, order: list[str]) -> None:
        self.name = name
        self.order = order

    def hop(self, request: int) -> float:
        self.order.append(self.name)
        return request * 1e-6


def numbers() -> Iterator[int]:
    return iter(count())


def test_blocks_are_in_turn_and_the_order_turns_round() -> None:
    order: list[str] = []
    watched = Watched()
    times = hops_in_turn(watched, (Line("a", order), Line("b", order)), (numbers(), numbers()), blocks=3, size=2)
    assert order[: 2 * WARM_UP] == ["a"] * WARM_UP + ["b"] * WARM_UP
    assert "".join(order[2 * WARM_UP :]) == "aabb" + "bbaa" + "aabb"
    assert watched.blocks == 6
    # Each went through its own requests, of which the warm-up took the first.
    for own in times:
        assert own == pytest.approx([WARM_UP + k for k in range(6)])


def test_the_first_line_stands_beside_the_second() -> None:
    median, p99 = hop_results("hop", ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), "peer", 1.5, ", load 0.1")
    assert (median.name, median.value, median.peer_value) == ("hop_median", 2.0, 5.0)
    assert p99.name == "hop_p99"
    assert p99.value <= 3.0
    assert median.note == "round trip, 3 requests each in alternate blocks, load 0.1"


def test_a_pace_is_kept_between_requests(monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[float] = []
    now = [0.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])

    class Spun(Watched):
        """Time goes on only while its executor waits."""

        class executor:  # noqa: N801
            @staticmethod
            def spin_once(timeout_sec: float) -> None:
                now[0] += timeout_sec

    class Timed(Line):
        def hop(self, request: int) -> float:
            begun.append(time.perf_counter())
            return super().hop(request)

    lines = Timed("a", []), Timed("b", [])
    times = hops_in_turn(Spun(), lines, (numbers(), numbers()), blocks=1, size=3, pace=0.25)
    after_warm_up = begun[2 * WARM_UP :]
    assert min(after - before for before, after in itertools.pairwise(after_warm_up)) >= 0.25
    # What is waited for the next one is no part of a hop.
    assert times[0] == pytest.approx([WARM_UP + k for k in range(3)])
