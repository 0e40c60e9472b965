"""Which set points the controller is said to have heard, where the recording lacks an answer."""

from __future__ import annotations

from typing import Any

from dp_msgs.msg import ControllerStatus
from geometry_msgs.msg import PoseStamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

from dp_node import from_nanoseconds
from dp_tools.node_settings import CONTROLLER
from dp_tools.reexecution.evidence import Evidence, Node, evidence_of
from dp_tools.reexecution.feed import Changed, Heard
from dp_tools.reexecution.recording import Recorded


def at(published: int, kind: Any, stamp: int, number: int = 1) -> Recorded:
    message = kind()
    message.header.stamp = from_nanoseconds(stamp)
    return Recorded(published, published, number, bytes(serialize_message(message)))


def controller(changes: list[int], setpoints: list[Recorded], statuses: list[Recorded]) -> Evidence:
    """Samples at 100, 200 and 300, answered 10 later with a demand and 1 later with a status."""
    samples = (100, 200, 300)
    demands = [at(t + 10, WrenchStamped, t) for t in samples]
    own = [at(t + 11, ControllerStatus, t, 10) for t in samples]
    inputs = {"odometry": [at(t, Odometry, t) for t in samples], "setpoint": setpoints}
    outputs = {
        "tau_desired": demands,
        "controller_status": sorted([*own, *statuses], key=lambda one: one.published),
    }
    return evidence_of(CONTROLLER, Node(inputs, outputs, [(t, Changed(())) for t in changes], lambda message: None))


def heard(found: Evidence) -> list[int]:
    items = [*(act.item for act in found.acts), *(loose.item for loose in found.loose)]
    return sorted(one.message.published for one in items if isinstance(one, Heard) and one.topic == "setpoint")


def test_a_change_without_a_recorded_answer_does_not_take_that_of_a_set_point() -> None:
    setpoints = [at(150, PoseStamped, 0), at(250, PoseStamped, 0)]
    answers = [at(155, ControllerStatus, 100), at(255, ControllerStatus, 200)]
    assert heard(controller([50], setpoints, answers)) == [150, 250]
    # One with an answer of its own takes it.
    answered = [at(121, ControllerStatus, 100), *answers]
    found = controller([120], setpoints, answered)
    assert heard(found) == [150, 250]
    assert [act.answered for act in found.acts if isinstance(act.item, Heard) and act.item.topic == "setpoint"] == [
        155,
        255,
    ]


def test_a_set_point_before_the_recording_of_answers_was_heard() -> None:
    setpoints = [at(50, PoseStamped, 7), at(250, PoseStamped, 240)]
    later = [at(255, ControllerStatus, 240, 12)]
    assert heard(controller([], setpoints, later)) == [50, 250]


def test_a_set_point_without_an_answer_was_not_heard_where_all_answers_were_recorded() -> None:
    setpoints = [at(50, PoseStamped, 7), at(250, PoseStamped, 240)]
    first = [at(20, ControllerStatus, 5, 1), at(255, ControllerStatus, 240, 12)]
    found = controller([], setpoints, first)
    assert heard(found) == [250]
    assert found.unheard == {"setpoint": 1}
