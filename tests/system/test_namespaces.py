"""Two graphs on one machine at the same time: each in its namespace, or each in its ROS domain."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.domains import reserve_domain_id
from support.dp_command import DpProcess, dp, write_scenario
from support.recordings import differences_from_in_process_loop, messages_by_topic, repeatable

pytestmark = [pytest.mark.timeout(300), pytest.mark.usefixtures("ros_domain_id")]


def test_two_graphs_do_not_disturb_one_another(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, 6.0, events=[{"at": 0.0, "setpoint": [0.1, 0.0, 0.0]}])

    def start(name: str) -> DpProcess:
        how = ("--lockstep", "--composed", "--record", "--namespace", name)
        return DpProcess("up", "--scenario", scenario, *how, "--output", tmp_path / name)

    with start("port") as port, start("fleet/starboard") as starboard:
        for process in (port, starboard):
            assert process.wait() == 0, process.output
    ours = messages_by_topic(tmp_path / "port" / "bag")
    other = messages_by_topic(tmp_path / "fleet" / "starboard" / "bag")
    # Nothing of the other graph is in the recording, apart from what all graphs share.
    assert {topic for topic in ours if not topic.startswith("/port/")} <= {
        "/diagnostics",
        "/rosout",
        "/parameter_events",
    }
    topics = repeatable(ours)
    assert {"/port/pose", "/port/thruster_command", "/port/clock"} <= set(topics)
    assert [t.replace("/port/", "/fleet/starboard/") for t in topics] == repeatable(other)
    for topic in topics:
        assert ours[topic] == other[topic.replace("/port/", "/fleet/starboard/")], topic


def test_a_second_graph_of_the_same_name_is_refused(tmp_path: Path) -> None:
    with DpProcess("up", "--composed", "--output", tmp_path / "first") as first:
        first.wait_until(lambda: "Ctrl-C stops" in first.output, "the graph to run")
        code, output = dp("up", "--composed", "--record", "--output", tmp_path / "second")
        assert code == 1
        assert "namespace /: expected no graph, found one that another dp up runs" in output
        assert first.running
    assert not (tmp_path / "second" / "bag").exists()


def test_two_graphs_in_two_domains_sail_as_if_alone(tmp_path: Path) -> None:
    """At the same time, with the same names, and seeds of their own: a message that crossed would show."""

    def start(name: str, seed: int, domain: int) -> DpProcess:
        (tmp_path / name).mkdir()
        events = [{"at": 0.0, "setpoint": [0.1, 0.0, 0.0]}]
        scenario = write_scenario(tmp_path / name, 6.0, events=events, seed=seed)
        how = ("--lockstep", "--composed", "--record", "--output", tmp_path / name / "run")
        return DpProcess("up", "--scenario", scenario, *how, environment={"ROS_DOMAIN_ID": str(domain)})

    with (
        reserve_domain_id() as first,
        reserve_domain_id() as second,
        start("port", 7, first) as port,
        start("starboard", 8, second) as starboard,
    ):
        for process in (port, starboard):
            assert process.wait() == 0, process.output
    bags = [tmp_path / name / "run" / "bag" for name in ("port", "starboard")]
    ours, other = map(messages_by_topic, bags)
    assert repeatable(ours) == repeatable(other)
    assert ours["/pose"] != other["/pose"]
    for bag in bags:
        # Alone: the loop without middleware.
        differences = differences_from_in_process_loop(bag)
        assert len(differences) > 40
        assert {name: value for name, value in differences.items() if value != 0.0} == {}
