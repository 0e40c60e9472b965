"""`dp scenario run` on the lockstep graph: two seeds, judged, compared with in process, told in one table."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from dp_tools.bag_reader import read_bag
from dp_tools.campaign.comparison import differences
from dp_tools.campaign.fingerprint import fingerprint
from dp_tools.campaign.summary import read_summary
from dp_tools.in_process import ClosedLoop
from dp_tools.run_bag import write_bag
from support.dp_command import dp, own_domain, write_scenario
from support.recordings import messages_by_topic

pytestmark = pytest.mark.timeout(400)

FIGURES = [
    {"name": "power", "kind": "mean_power", "title": "Mean power", "window": "end", "at_least": 0.01},
    {"name": "turn", "kind": "azimuth_step", "title": "Largest turn", "at_most": 12.04, "thesis": 12.0},
]


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("graph")
    scenario = write_scenario(folder, windows={"end": [4.0, 20.0]}, figures=FIGURES)
    with own_domain() as domain:
        words = ("scenario", "run", scenario, "--compare", "--repeat", "2", "--output", folder / "runs")
        code, output = dp(*words, environment=domain)
    assert code == 0, output
    return folder / "runs", output


def test_graph_and_in_process_are_equal_to_the_bit_for_every_seed(sailed: tuple[Path, str]) -> None:
    folder, output = sailed
    summary = read_summary(folder / "trial" / "seeds.json")
    assert summary.seeds == (7, 8)
    for outcome in summary.outcomes:
        assert outcome.apart is not None
        assert len(outcome.apart) > 40
        assert {name: size for name, size in outcome.apart.items() if size != 0.0} == {}
    assert len({outcome.fingerprint for outcome in summary.outcomes}) == 2
    assert "equal to the bit" in output
    assert "equal to the bit" in (folder / "index.html").read_text(encoding="utf-8")


def test_the_first_seed_leaves_recording_and_report_the_second_nothing(sailed: tuple[Path, str]) -> None:
    folder, _ = sailed
    found = {path.name for path in (folder / "trial").iterdir()}
    assert found == {"bag", "logs", "parameters.yaml", "report.html", "figures.json", "seeds.json"}
    assert read_bag(folder / "trial" / "bag").run.info.seed == 7


def test_every_figure_has_its_verdict(sailed: tuple[Path, str]) -> None:
    folder, _ = sailed
    (run,) = json.loads((folder / "index.json").read_text(encoding="utf-8"))["runs"]
    verdicts = {figure["name"]: figure["verdicts"] for figure in run["figures"]}
    assert verdicts == {"power": ["holds"], "turn": ["holds", "agrees"]}
    assert run["apart"] == {"series": "", "largest": 0.0}


def test_a_bag_of_a_run_in_process_is_that_of_the_graph(sailed: tuple[Path, str], tmp_path: Path) -> None:
    """The same run, the same topics, types, schemas and numbers of messages; where all is logged, the same bytes."""
    folder, _ = sailed
    graph = read_bag(folder / "trial" / "bag")
    assert graph.scenario is not None
    run = ClosedLoop(graph.vessel, graph.scenario).run()
    own = write_bag(tmp_path / "bag", run, graph.vessel, graph.scenario)
    assert fingerprint(read_bag(own).run) == fingerprint(graph.run)
    assert set(differences(read_bag(own).run, graph.run).values()) == {0.0}
    of_graph, of_run = (_topics(path) for path in (folder / "trial" / "bag", own))
    assert {name: of_graph[name] for name in of_run} == of_run
    nowhere_logged = {"/diagnostics", "/rosout", "/environment_force"}
    assert {name for name in set(of_graph) - set(of_run) if not name.endswith("/transition_event")} == nowhere_logged
    messages, own_messages = messages_by_topic(folder / "trial" / "bag"), messages_by_topic(own)
    for topic in ("/tau_desired", "/tau_achieved", "/thruster_command", "/propulsion_truth", "/clock"):
        assert own_messages[topic] == messages[topic], topic
    for topic, found in own_messages.items():
        # An operator's input is answered with a status, a command with a setpoint, stopping with another; nodes that
        # are no part of the graph tell of their parameters too.
        if topic not in ("/controller_status", "/actuator_setpoint", "/parameter_events"):
            assert len(found) == len(messages[topic]), topic


def _topics(bag: Path) -> dict[str, tuple[str, str]]:
    """Return type and hash of every topic with a message."""
    document = yaml.safe_load((bag / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    return {
        topic["topic_metadata"]["name"]: (
            topic["topic_metadata"]["type"],
            topic["topic_metadata"]["type_description_hash"],
        )
        for topic in document["topics_with_message_count"]
        if topic["message_count"]
    }
