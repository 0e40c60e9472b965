"""What events of the middleware and counts of a node come to, without a middleware."""

from __future__ import annotations

from types import SimpleNamespace

from rclpy.qos import QoSPolicyKind

from dp_node import Health, Level, health_with, raised
from dp_node.alarms import Alarm
from dp_node.common_health import NodeCounts, health_of
from dp_node.quality_events import QualityEvents

ACTIVE = NodeCounts(state="active", refused=0, fresh_refused=0, last_refusal="", ignored=0)


def told(alarms: list[Alarm]) -> list[tuple[str, str]]:
    return [(alarm.kind.code, alarm.detail) for alarm in alarms]


def test_a_publisher_counts_as_gone_once_one_was_alive_and_none_is() -> None:
    events = QualityEvents()
    heard = events.subscription("odometry", lambda: 0)
    assert told(events.report()) == []
    heard.liveliness(SimpleNamespace(alive_count=0))  # the first sign of life may still be on its way
    assert told(events.report()) == []
    heard.liveliness(SimpleNamespace(alive_count=1))
    assert told(events.report()) == []
    heard.liveliness(SimpleNamespace(alive_count=0))
    assert told(events.report()) == told(events.report()) == [("NODE-LIVELINESS-LOST", "odometry")]
    heard.liveliness(SimpleNamespace(alive_count=1))
    assert told(events.report()) == []


def test_missed_deadlines_and_lost_messages_are_told_once() -> None:
    events = QualityEvents()
    heard = events.subscription("odometry", lambda: 0)
    heard.deadline(SimpleNamespace(total_count_change=2))
    heard.deadline(SimpleNamespace(total_count_change=1))
    heard.message_lost(SimpleNamespace(total_count_change=7))
    assert told(events.report()) == [
        ("NODE-DEADLINE-MISSED", "odometry, 3 times"),
        ("NODE-MESSAGES-LOST", "odometry, 7"),
    ]
    assert told(events.report()) == []


def test_who_does_not_fit_is_told_with_topic_and_policy_while_he_is_there() -> None:
    events, there = QualityEvents(), [1]
    heard = events.subscription("tau_desired", lambda: there[0])
    assert told(events.report()) == [], "the graph may count a publisher before it is matched"
    heard.incompatible_qos(SimpleNamespace(last_policy_kind=QoSPolicyKind.LIVELINESS))
    assert told(events.report()) == [("NODE-QOS-INCOMPATIBLE", "tau_desired, liveliness, 1 of its ends")]
    there[0] = 0
    assert told(events.report()) == []
    sent = events.publisher("pose", lambda: 2)
    sent.incompatible_qos(SimpleNamespace(last_policy_kind=QoSPolicyKind.DEADLINE))
    assert told(events.report()) == [("NODE-QOS-INCOMPATIBLE", "pose, deadline, 2 of its ends")]
    events.forget()
    assert told(events.report()) == []


def test_a_node_that_is_not_active_says_so_and_nothing_of_its_core() -> None:
    core = health_with([raised("DRIVERS-NO-FEEDBACK")], {"feedback": 3})
    counts = NodeCounts(state="inactive", refused=2, fresh_refused=0, last_refusal="why", ignored=4)
    health = health_of(counts, core)
    assert (health.level, health.message) == (Level.WARN, "the node is not active: inactive")
    assert told(list(health.alarms)) == [("NODE-NOT-ACTIVE", "inactive")]
    assert health.values == {
        "feedback": 3,
        "state": "inactive",
        "refused_inputs": 2,
        "ignored_inputs": 4,
        "last_refusal": "why",
        "refused_of_others": 0,
    }


def test_refusals_and_topics_are_added_to_what_the_core_says() -> None:
    counts = NodeCounts("active", 1, 1, "pose: too far", 0, 0, (raised("NODE-MESSAGES-LOST", "pose, 7"),))
    health = health_of(counts, health_with([raised("OBSERVER-DEAD-RECKONING")]))
    assert told(list(health.alarms)) == [
        ("OBSERVER-DEAD-RECKONING", ""),
        ("NODE-INPUT-REFUSED", "pose: too far"),
        ("NODE-MESSAGES-LOST", "pose, 7"),
    ]
    assert health.message.startswith("no position fix: dead reckoning; refused: pose: too far; messages were lost")
    assert health_of(ACTIVE, Health(message="sailing")).message == "sailing"
