"""Inboxes and the waiting room."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dp_node import Inbox, WaitingRoom


def test_the_newest_before_a_stamp_is_taken_once() -> None:
    inbox: Inbox[str] = Inbox("power")
    assert inbox.take(10) is None
    for stamp, value in ((1, "a"), (3, "b"), (5, "c")):
        inbox.put(stamp, value)
    assert inbox.take(5) == (3, "b")
    assert inbox.take(5) is None
    assert inbox.take(4) is None
    assert inbox.take(6) == (5, "c")
    inbox.put(7, None)  # refused: nothing older stands in for it
    assert inbox.take(8) is None
    inbox.clear()
    assert (len(inbox), inbox.take(8)) == (0, None)


@given(stamps=st.lists(st.integers(0, 1000), unique=True), asked=st.integers(0, 1001))
def test_any_stamps(stamps: list[int], asked: int) -> None:
    inbox: Inbox[int] = Inbox("power")
    for stamp in sorted(stamps):
        inbox.put(stamp, -stamp)
    before = [stamp for stamp in stamps if stamp < asked]
    assert inbox.take(asked) == ((max(before), -max(before)) if before else None)
    assert inbox.reaches(asked) == any(stamp >= asked for stamp in stamps)


def test_a_demand_waits_for_every_inbox_that_is_needed() -> None:
    power, ventilation = Inbox[float]("power"), Inbox[float]("ventilation")
    room: WaitingRoom[str] = WaitingRoom(2)
    both = [power, ventilation]
    assert room.release(both) is None
    assert room.missing(10, both) == ["power", "ventilation"]
    room.hold(10, "demand")
    power.put(7, 1.0)
    assert room.waits_for(both) == ["power", "ventilation"]
    ventilation.put(8, 1.0)
    assert room.waits_for(both) == ["power"]
    assert room.release(both) is None
    power.put(8, None)  # refused is an answer too
    assert room.release(both) == "demand"
    assert room.release(both) is None
    room.hold(20, "next")
    assert room.release([]) == "next"  # nothing is needed any more
    room.hold(30, "last")
    room.clear()
    assert room.waits_for(both) == []
