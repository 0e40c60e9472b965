"""The order in which a node took its inputs, out of publish times; made-up cases, worked out by hand."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message

from dp_tools.reexecution.evidence import Evidence, Node, evidence_of
from dp_tools.reexecution.feed import Changed, Due, Heard
from dp_tools.reexecution.order import PATIENCE, Act, Loose, Order, merge
from dp_tools.reexecution.recording import Recorded
from dp_tools.reexecution.trial import other_orders

MS = 1_000_000
SECOND = 1_000_000_000


def fed(order: Order[str]) -> list[str]:
    steps = []
    for number in range(len(order.acts) + 1):
        steps += [order.loose[i].item for i in order.between(number)]
        if number < len(order.acts):
            steps.append(order.acts[number].item)
    return steps


def test_a_message_published_before_an_act_can_have_begun_comes_before_it() -> None:
    acts = [Act("a", 100 * MS, 101 * MS, 102 * MS), Act("b", 200 * MS, 201 * MS, 202 * MS)]
    loose = [Loose("x", 50 * MS), Loose("y", 150 * MS), Loose("z", 250 * MS)]
    assert fed(merge(acts, loose)) == ["x", "a", "y", "b", "z"]


def test_acts_follow_their_answers_and_not_what_they_answer() -> None:
    # b was published first, but the node answered a first.
    acts = [Act("b", 1 * MS, 9 * MS, 9 * MS), Act("a", 2 * MS, 8 * MS, 8 * MS)]
    assert fed(merge(acts, [])) == ["a", "b"]


def test_what_came_while_the_node_was_busy_comes_before_the_next_act() -> None:
    # b was waiting from 11 ms on, but the node was busy with a until 30 ms; x came at 20 ms.
    acts = [Act("a", 10 * MS, 15 * MS, 30 * MS), Act("b", 11 * MS, 31 * MS, 31 * MS)]
    order = merge(acts, [Loose("x", 20 * MS)])
    assert fed(order) == ["a", "x", "b"]
    # Not before a, which was answered by then; but it may have waited longer than b.
    assert order.range == [(1, 2)]
    assert (order.unsure(0), order.unsure(1)) == ([], [0])


def test_after_its_patience_no_process_lets_a_message_wait() -> None:
    acts = [Act("a", 100 * MS, 101 * MS, 101 * MS), Act("b", 200 * MS + PATIENCE, 201 * MS + PATIENCE, 0)]
    order = merge(acts, [Loose("x", 150 * MS)])
    assert order.range == [(1, 1)]
    assert order.unsure(0) == order.unsure(1) == []


def test_a_message_that_waited_is_tried_after_the_act() -> None:
    order = merge([Act("a", 100 * MS, 101 * MS, 101 * MS)], [Loose("x", 95 * MS)])
    assert fed(order) == ["x", "a"]
    assert list(other_orders(order, 0, lambda i: "topic")) == [{0: 1}]
    order.move(0, 1)
    assert fed(order) == ["a", "x"]


def test_messages_of_one_topic_keep_their_order_in_every_order_that_is_tried() -> None:
    acts = [Act("a", 100 * MS, 101 * MS, 101 * MS)]
    order = merge(acts, [Loose("x", 98 * MS), Loose("y", 99 * MS)])
    tried = []
    for places in other_orders(order, 0, lambda i: "topic"):
        again = merge(acts, order.loose)
        for i, number in places.items():
            again.move(i, number)
        tried.append(fed(again))
    # The nearest to what holds first.
    assert tried == [["x", "a", "y"], ["a", "x", "y"]]


# Evidence ------------------------------------------------------------------------------------------------------------


def message(stamp: float, published: float) -> Recorded:
    """A message with a header, at seconds of simulated time, published at milliseconds."""
    sec, nanosec = divmod(round(stamp * SECOND), SECOND)
    one = WrenchStamped()
    one.header.stamp = Time(sec=sec, nanosec=nanosec)
    time = round(published * MS)
    return Recorded(time, time, 0, serialize_message(one))


def node(inputs: dict[str, Any], outputs: dict[str, Any], changes: Any = (), command: Any = None) -> Node:
    in_force = command or {}
    return Node(inputs, outputs, changes, lambda answer: in_force.get(answer.published))


def acts(found: Evidence) -> list[tuple[Any, ...]]:
    shown: list[tuple[Any, ...]] = []
    for act in sorted(found.acts, key=lambda act: act.answered):
        item = act.item
        name = item.topic if isinstance(item, Heard) else type(item).__name__
        shown.append((name, act.published / MS, act.answered / MS, act.finished / MS))
    return shown


def test_a_pose_is_answered_with_the_odometry_of_its_stamp_and_the_watchdog_answers_nothing() -> None:
    poses = [message(0.0, 1), message(0.2, 11), message(0.6, 31)]
    odometry = [message(0.2, 12), message(0.4, 25), message(0.6, 32)]
    states = [message(0.2, 13), message(0.4, 26), message(0.6, 33)]
    found = evidence_of(
        "dp_observer", node({"pose": poses, "tau_achieved": []}, {"odometry": odometry, "observer_state": states})
    )
    assert acts(found) == [("pose", 11, 12, 13), ("Due", 25, 25, 25), ("pose", 31, 32, 33)]
    # The first pose was published before the observer heard anything.
    assert found.unheard == {"pose": 1}
    assert found.loose == []
    assert [act.item.stamp for act in found.acts if isinstance(act.item, Due)] == [round(0.4 * SECOND)]


def test_a_repeated_pose_is_loose_it_is_refused_again() -> None:
    poses = [message(0.2, 1), message(0.2, 2), message(0.4, 11)]
    found = evidence_of("dp_observer", node({"pose": poses}, {"odometry": [message(0.2, 1.5), message(0.4, 12)]}))
    assert acts(found) == [("pose", 1, 1.5, 1.5), ("pose", 11, 12, 12)]
    assert [one.published for one in found.loose] == [2 * MS]


def test_the_command_in_force_says_when_a_command_was_taken() -> None:
    feedback = [message(0.00, 1), message(0.02, 10), message(0.04, 20)]
    commands = [message(0.0, 2), message(0.02, 11)]
    # The second command overtook the feedback of its stamp.
    answers = [message(0.00, 3), message(0.0, 4), message(0.02, 13), message(0.02, 14), message(0.04, 21)]
    in_force = {3 * MS: None, 4 * MS: 0, 13 * MS: SECOND // 50, 14 * MS: SECOND // 50, 21 * MS: SECOND // 50}
    given = node(
        {"thruster_feedback": feedback, "thruster_command": commands}, {"actuator_setpoint": answers}, command=in_force
    )
    assert acts(evidence_of("thruster_drivers", given)) == [
        ("thruster_feedback", 1, 3, 3),
        ("thruster_command", 2, 4, 4),
        ("thruster_command", 11, 13, 13),
        ("thruster_feedback", 10, 14, 14),
        ("thruster_feedback", 20, 21, 21),
    ]


def test_statuses_tell_when_an_operator_was_heard_and_a_change_took_effect() -> None:
    odometry = [message(0.2, 1), message(0.4, 11)]
    demands = [message(0.2, 2), message(0.4, 12)]
    statuses = [message(0.2, 2.5), message(0.2, 5.1), message(0.3, 6), message(0.4, 12.5), message(0.4, 15)]
    setpoints = [message(0.3, 4), message(0.0, 14)]
    changes = [(5 * MS, Changed(()))]
    given = node(
        {"odometry": odometry, "setpoint": setpoints, "tau_achieved": []},
        {"tau_desired": demands, "controller_status": statuses},
        changes,
    )
    # The second set point has no stamp: it is answered with that of the last odometry.
    assert acts(evidence_of("dp_controller", given)) == [
        ("odometry", 1, 2, 2),
        ("Changed", 5, 5, 5),
        ("setpoint", 4, 6, 6),
        ("odometry", 11, 12, 12),
        ("setpoint", 14, 15, 15),
    ]


def test_the_simulator_steps_from_its_first_message_to_the_next_clock() -> None:
    outputs = {
        "truth": [message(0.0, 1)],
        "thruster_feedback": [message(0.0, 3), message(0.02, 11)],
        "clock": [],
    }
    given = node({"actuator_setpoint": [message(0.0, 5)]}, outputs)
    found = evidence_of("vessel_sim", given)
    assert acts(found) == [("Due", 1, 1, 3), ("Due", 11, 11, 11)]
    assert [one.published for one in found.loose] == [5 * MS]
