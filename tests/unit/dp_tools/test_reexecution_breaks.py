"""A node that was restarted or deactivated while it was recorded: judged until then, and said so."""

from __future__ import annotations

from pathlib import Path

from lifecycle_msgs.msg import State, TransitionEvent
from rclpy.serialization import serialize_message

from dp_tools.reexecution.breaks import first_break, until
from dp_tools.reexecution.recording import Recorded, Recording, Topic


def numbered(*numbers: int) -> list[Recorded]:
    return [Recorded(10 * k, 10 * k + 1, number, b"") for k, number in enumerate(numbers)]


def leaving(start: int, goal: int) -> Recorded:
    event = TransitionEvent(start_state=State(id=start), goal_state=State(id=goal))
    return Recorded(15, 16, 1, bytes(serialize_message(event)))


def test_numbers_that_begin_again_are_a_restart() -> None:
    assert first_break({"a": numbered(1, 2, 3), "b": numbered(7, 8, 12)}, []) is None
    # Unknown numbers tell nothing.
    assert first_break({"a": numbered(0, 0, 0)}, []) is None
    found = first_break({"a": numbered(1, 2, 3, 1, 2), "b": numbered(5, 6)}, [])
    assert found is not None
    assert (found.time, found.last, found.reason) == (30, 20, "restarted")


def test_leaving_active_is_a_break_and_shutting_down_is_none() -> None:
    active = State.PRIMARY_STATE_ACTIVE
    assert first_break({"a": numbered(1, 2)}, [leaving(active, State.TRANSITION_STATE_SHUTTINGDOWN)]) is None
    assert first_break({"a": numbered(1, 2)}, [leaving(State.PRIMARY_STATE_INACTIVE, active)]) is None
    found = first_break({"a": numbered(1, 2, 3)}, [leaving(active, State.TRANSITION_STATE_DEACTIVATING)])
    assert found is not None
    assert (found.time, found.last, found.reason) == (15, 10, "deactivated")


def test_what_came_after_is_left_out() -> None:
    topics = {name: Topic(name, "", "", (), numbered(1, 2, 3, 1)) for name in ("/a", "/input", "/parameter_events")}
    recording = Recording(Path(), topics, [], {}, 0)
    broken = first_break({"a": topics["/a"].messages}, [])
    assert broken is not None
    left = until(recording, broken, ["/a"]).topics
    assert [len(left[name].messages) for name in topics] == [3, 4, 3]
    assert len(topics["/a"].messages) == 4
