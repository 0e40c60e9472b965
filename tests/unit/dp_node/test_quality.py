"""Who hears whom, by the quality of service of every topic; the middleware itself judges what is compatible."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible

from dp_node.quality import OFFERED_LEASE, RING_PUBLISHER, TOPICS, Promise, offered, quality_of, requested
from marine_model.errors import InputError

ROOT = Path(__file__).parents[3]
NOTHING = Promise()
STRICT = Promise(lease=OFFERED_LEASE, deadline=0.5)
DEFAULT = QoSProfile(depth=10)  # of rclpy, rclcpp and `ros2 topic pub`: reliable, volatile, no lease, no deadline
OURS = sorted(topic for topic, quality in TOPICS.items() if quality.ours)
FOREIGN = sorted(set(TOPICS) - set(OURS))


def hears(publisher: QoSProfile, subscription: QoSProfile) -> bool:
    return qos_check_compatible(publisher, subscription)[0] != QoSCompatibility.ERROR


@pytest.mark.parametrize("topic", sorted(TOPICS))
@pytest.mark.parametrize("lockstep", [False, True])
@pytest.mark.parametrize("promise", [NOTHING, STRICT, Promise(lease=5.0)], ids=["nothing", "strict", "lease"])
def test_our_nodes_hear_each_other_in_every_pace(topic: str, lockstep: bool, promise: Promise) -> None:
    assert hears(offered(topic, promise), requested(topic, lockstep, promise))


@pytest.mark.parametrize("topic", sorted(TOPICS))
def test_default_subscribers_hear_all_of_our_topics(topic: str) -> None:
    assert hears(offered(topic, STRICT), DEFAULT)


@pytest.mark.parametrize("topic", FOREIGN)
def test_default_publishers_are_heard_on_the_topics_of_vessel_and_operator_whatever_the_ring_promises(
    topic: str,
) -> None:
    assert hears(DEFAULT, requested(topic, False, STRICT))
    assert hears(DEFAULT, requested(topic, True, STRICT)) == quality_of(topic).volatile


@pytest.mark.parametrize("topic", OURS)
def test_a_player_of_bags_is_heard_within_the_ring_unless_a_lease_or_a_deadline_is_asked_for(topic: str) -> None:
    """`ros2 bag play` offers reliability and durability as recorded, and neither lease nor deadline."""
    assert hears(RING_PUBLISHER, requested(topic, False, NOTHING))
    assert hears(RING_PUBLISHER, requested(topic, True, NOTHING))
    assert not hears(RING_PUBLISHER, requested(topic, False, Promise(lease=OFFERED_LEASE)))
    assert not hears(RING_PUBLISHER, requested(topic, False, Promise(deadline=1.0)))


@pytest.mark.parametrize(
    ("lease", "deadline", "said"),
    [
        (1.9, 0.0, r"input_lease: expected 0 or at least 2\.0 s, which publishers offer, found 1\.9"),
        (float("inf"), 0.0, "input_lease: expected 0"),
        (float("nan"), 0.0, "input_lease: expected 0"),
        (0.0, -1.0, r"input_deadline: expected 0 or more seconds, found -1\.0"),
        (0.0, float("inf"), "input_deadline: expected 0"),
    ],
)
def test_times_that_cannot_be_kept_are_refused(lease: float, deadline: float, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Promise(lease, deadline)


def topics_of_the_nodes() -> set[str]:
    """Every topic that a node of ours publishes or hears, as written in its source."""
    found = set()
    for path in ROOT.glob("src/*/*/node.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = {
            target.id: node.value.value
            for node in tree.body
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        for call in ast.walk(tree):
            if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)):
                continue
            if call.func.attr in ("listen", "publish_on"):
                topic = call.args[1]
                value = topic.value if isinstance(topic, ast.Constant) else names.get(getattr(topic, "id", ""))
                assert isinstance(value, str), f"{path}:{call.lineno}: expected the name of a topic"
                found.add(value)
    return found


def test_the_table_holds_every_topic_of_the_nodes_and_no_other() -> None:
    assert topics_of_the_nodes() | {"/diagnostics"} == set(TOPICS)


def test_the_page_lists_every_topic_under_its_kind() -> None:
    page = (ROOT / "docs" / "dp_node.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1:] for line in page.splitlines() if line.startswith("| `") and line.count("|") == 6]
    told = {
        name.strip(" `"): (volatile.strip(), ours.strip())
        for names, _, volatile, ours, *_ in rows
        for name in names.split(",")
    }
    words = {True: "yes", False: "no"}
    assert told == {name: (words[q.volatile], words[q.ours]) for name, q in TOPICS.items()}
