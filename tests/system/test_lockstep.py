"""Lockstep: the same to the bit in five processes and in one, and equal to the loop without middleware."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dp_tools.bag_reader import read_bag
from support.dp_command import dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop, messages_by_topic, repeatable

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same scenario, sailed by five processes and by one."""
    folder = tmp_path_factory.mktemp("lockstep")
    scenario = write_scenario(folder)
    options: dict[str, tuple[str, ...]] = {"separate": (), "composed": ("--composed",)}
    for name, how in options.items():
        with own_domain() as domain:
            words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(folder / name), *how)
            code, output = dp(*words, environment=domain)
        assert code == 0, output
    return {name: folder / name / "bag" for name in options}


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


def test_the_run_has_noise_waves_and_every_event(bags: dict[str, Path]) -> None:
    """So that equal bytes mean something."""
    recorded = read_bag(bags["composed"]).run
    assert len(np.unique(recorded["pose"].values[:, 0])) == 100
    assert np.abs(recorded["wave_position"].values).max() > 0.001
    assert recorded.labels["azimuth_mode"].words == ("fixed", "rotating", "fixed")
    assert np.abs(recorded["reference_position"].values[-1]).max() > 0.05


@pytest.mark.parametrize("how", ["separate", "composed"])
def test_graph_equals_the_loop_without_middleware(bags: dict[str, Path], how: str) -> None:
    """Equal in every bit: the same cores, fed the same doubles in the same order, on one machine."""
    differences = differences_from_in_process_loop(bags[how])
    assert len(differences) > 40
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
