"""When a replay sends what: rate, pause, steps, loop, lateness; by a clock that only the test moves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dp_tools.bags.bag import open_bag
from dp_tools.bags.errors import BagError
from dp_tools.replay.player import Player
from dp_tools.replay.schedule import Schedule, make_schedule
from dp_tools.replay.timeline import Timeline
from marine_model.errors import InputError
from support.made_bag import CLOCK, START, Message, clock, make_bag, text_in

MS = 1_000_000


class Bench:
    """A player whose time the test moves, in ms."""

    def __init__(self, due: list[int], samples: list[int] | None = None, **options) -> None:
        self.now = 5_000 * MS
        self.sent: list[tuple[int, int]] = []
        rows = np.arange(len(due))
        times = np.array(due) * MS
        schedule = Schedule(rows, times, 0, int(times[-1]), 0, np.array(samples or [], dtype=np.int64))
        self.player = Player(schedule, self.send, lambda: self.now, **options)
        self.player.begin()

    def send(self, row: int) -> None:
        self.sent.append((row, (self.now - 5_000 * MS) // MS))

    def run(self, until: int) -> list[tuple[int, int]]:
        """Let time pass from one due message to the next, up to ``until`` ms; return (row, ms) of what was sent."""
        end = 5_000 * MS + until * MS
        while (wake := self.player.advance()) is not None and wake <= end:
            self.now = max(wake, self.now)
        self.now = end
        self.player.advance()
        sent, self.sent = self.sent, []
        return sent


def test_messages_go_out_at_their_times() -> None:
    bench = Bench([0, 10, 10, 35])
    assert bench.run(9) == [(0, 0)]
    assert bench.run(100) == [(1, 10), (2, 10), (3, 35)]
    assert bench.player.ended
    assert (bench.player.sent, bench.player.worst) == (4, 0)


@pytest.mark.parametrize(("rate", "times"), [(2.0, [0, 50, 100]), (0.5, [0, 200, 400])])
def test_rate(rate: float, times: list[int]) -> None:
    assert [at for _, at in Bench([0, 100, 200], rate=rate).run(1000)] == times


def test_rate_changes_from_now_on() -> None:
    bench = Bench([0, 100, 200, 300])
    assert bench.run(150) == [(0, 0), (1, 100)]
    bench.player.set_rate(2.0)
    assert bench.run(1000) == [(2, 175), (3, 225)]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused_and_the_old_one_kept(rate: float) -> None:
    bench = Bench([0, 100])
    with pytest.raises(InputError, match="rate: expected a number above 0"):
        bench.player.set_rate(rate)
    assert bench.run(1000) == [(0, 0), (1, 100)]


def test_pause_and_resume() -> None:
    bench = Bench([0, 100, 200])
    bench.run(150)
    bench.player.pause()
    assert bench.run(5000) == []
    assert bench.player.position == 150 * MS
    bench.player.resume()
    assert bench.run(6000) == [(2, 5050)]


def test_paused_start_and_steps() -> None:
    bench = Bench([0, 10, 20, 30], paused=True)
    assert bench.run(100) == []
    assert bench.player.step() == 1
    assert bench.player.step() == 1
    assert [row for row, _ in bench.sent] == [0, 1]
    assert bench.player.position == 10 * MS
    bench.player.resume()
    bench.sent.clear()
    assert bench.run(1000) == [(2, 110), (3, 120)]
    assert bench.player.step() == 0


def test_a_sample_ends_where_the_next_begins() -> None:
    bench = Bench([0, 1, 2, 10, 11, 20], samples=[1, 3, 5], paused=True)
    assert [bench.player.step_sample() for _ in range(5)] == [1, 2, 2, 1, 0]
    assert bench.player.ended


def test_a_sample_of_a_bag_without_samples_is_a_message() -> None:
    assert Bench([0, 1], paused=True).player.step_sample() == 1


def test_late_messages_go_out_at_once_and_none_is_left_out() -> None:
    bench = Bench([0, 10, 20, 30])
    bench.player.advance()
    bench.now += 25 * MS
    bench.player.advance()
    assert [row for row, _ in bench.sent] == [0, 1, 2]
    assert (bench.player.worst, bench.player.worst_at) == (15 * MS, 10 * MS)
    bench.sent.clear()
    # The delay is not carried on.
    assert bench.run(100) == [(3, 30)]


def test_a_long_debt_gives_way_to_others() -> None:
    bench = Bench([0] * 100)

    def slow(row: int) -> None:
        bench.now += MS

    bench.player._send = slow
    assert bench.player.advance() is not None
    assert 0 < bench.player.sent < 10


def test_loop_begins_anew_without_drift() -> None:
    bench = Bench([0, 10, 30], loop=True)
    assert bench.run(75) == [(0, 0), (1, 10), (2, 30), (0, 30), (1, 40), (2, 60), (0, 60), (1, 70)]
    assert bench.player.rounds == 2


@given(st.lists(st.tuples(st.floats(0.01, 100.0), st.integers(0, 10**9)), max_size=20))
def test_bag_time_never_goes_back(changes: list[tuple[float, int]]) -> None:
    line = Timeline(0, 0)
    now, last = 0, 0
    for rate, wait in changes:
        now += wait
        line.set_rate(rate, now)
        assert line.at(now) >= last - 1  # ns: rounding
        last = line.at(now)


def test_schedule_is_in_the_order_of_publishing(tmp_path: Path) -> None:
    """The recorder writes topic by topic what has arrived."""
    bag = make_bag(tmp_path / "bag", [("/a", 0.0, "0"), ("/a", 0.2, "2"), ("/b", 0.1, "1"), ("/b", 0.3, "3")])
    with open_bag(bag) as opened:
        names = {"/a": "/a", "/b": "/b"}
        schedule = make_schedule(opened, names)
        assert [text_in(opened.data(row)) for row in schedule.rows] == ["0", "1", "2", "3"]
        assert schedule.due.tolist() == [0, 100 * MS, 200 * MS, 300 * MS]
        assert schedule.origin == START
        assert make_schedule(opened, names, "log").origin == START + MS
        part = make_schedule(opened, names, start=0.1, until=0.2)
        assert [text_in(opened.data(row)) for row in part.rows] == ["1", "2"]
        assert part.begin == 100 * MS
        with pytest.raises(BagError, match=r"no message of these topics in that time; the bag is 0\.300 s long"):
            make_schedule(opened, names, start=2.0)
        with pytest.raises(BagError, match="simulated time needs one clock, found none"):
            make_schedule(opened, names, start=2.0, simulated=True)


def test_simulated_time_is_what_the_clock_told(tmp_path: Path) -> None:
    sent: list[Message] = [("/a", 0.0, "before")]
    for k in range(10):
        sent += [("/clock", 1.0 + k, clock(0.1 * k)), ("/a", 1.5 + k, str(k))]
    bag = make_bag(tmp_path / "bag", sent, {"/clock": CLOCK})
    with open_bag(bag) as opened:

        def told(**part) -> list[str]:
            schedule = make_schedule(opened, {"/a": "/a"}, simulated=True, **part)
            return [text_in(opened.data(row)) for row in schedule.rows]

        assert told(start=0.3, until=0.5) == ["3", "4", "5"]
        assert told(start=0.0, until=0.1) == ["before", "0", "1"]
        assert told(start=0.75) == ["8", "9"]
        with pytest.raises(BagError, match="no message of these topics in that time"):
            told(start=1.0)
