"""Lockstep: the same to the bit in five processes and in one, and equal to the loop without middleware."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.dp_command import dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop, messages_by_topic, repeatable

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same scenario, sailed by five processes, by one, and with another seed."""
    folder = tmp_path_factory.mktemp("lockstep")
    scenario = write_scenario(folder)
    other = folder / "other"
    other.mkdir()
    runs: dict[str, tuple[Path, tuple[str, ...]]] = {
        "separate": (scenario, ()),
        "composed": (scenario, ("--composed",)),
        "other seed": (write_scenario(other, seed=8), ("--composed",)),
    }
    found = {}
    for name, (path, options) in runs.items():
        with own_domain() as domain:
            words = ("up", "--scenario", str(path), "--lockstep", "--record", "--output", str(folder / name), *options)
            code, output = dp(*words, environment=domain)
        assert code == 0, output
        found[name] = folder / name / "bag"
    return found


def test_five_processes_and_one_send_the_same_bytes(bags: dict[str, Path]) -> None:
    separate, composed = messages_by_topic(bags["separate"]), messages_by_topic(bags["composed"])
    topics = repeatable(separate)
    assert {"/pose", "/odometry", "/tau_desired", "/thruster_command", "/thruster_feedback", "/clock"} < set(topics)
    assert topics == repeatable(composed)
    for topic in topics:
        assert len(separate[topic]) == len(composed[topic]), topic
        first = next(
            (i for i, pair in enumerate(zip(separate[topic], composed[topic], strict=True)) if len(set(pair)) > 1), None
        )
        assert first is None, f"{topic}: message {first} differs"


def test_another_seed_is_another_run(bags: dict[str, Path]) -> None:
    """So that equal bytes mean something."""
    ours, other = messages_by_topic(bags["composed"]), messages_by_topic(bags["other seed"])
    assert ours["/pose"] != other["/pose"]
    assert ours["/thruster_command"] != other["/thruster_command"]


@pytest.mark.parametrize("how", ["separate", "composed"])
def test_graph_equals_the_loop_without_middleware(bags: dict[str, Path], how: str) -> None:
    """Equal in every bit: the same cores, fed the same doubles in the same order, on one machine."""
    differences = differences_from_in_process_loop(bags[how])
    assert len(differences) > 40
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
