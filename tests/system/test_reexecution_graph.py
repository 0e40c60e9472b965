"""Bags of the real graph, in lockstep and in real time: every node verifies, from the bag alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.dp_command import LONGEST, dp, write_scenario

# Two commands, each of which has LONGEST.
pytestmark = pytest.mark.timeout(2 * LONGEST)

# Short, with what is hard to put in order: changes of parameters and inputs of an operator between samples.
FIELDS = {
    "events": [
        {"at": 0.0, "setpoint": [0.0, 0.0, 0.0]},
        {"at": 2.0, "parameters": {"thrust_allocator": {"azimuth_mode": "rotating"}}},
        {"at": 3.0, "setpoint": [0.3, -0.2, 0.1], "parameters": {"dp_controller": {"transfer_time": 1.0}}},
    ],
}


@pytest.mark.parametrize("pace", [("--lockstep", "--composed"), ("--rate", "5")], ids=["lockstep", "real-time"])
def test_every_node_of_a_recorded_graph_verifies(pace: tuple[str, ...], tmp_path: Path, ros_domain_id: int) -> None:
    scenario = write_scenario(tmp_path, duration=5.0, **FIELDS)
    _, said = dp("up", "--scenario", scenario, "--record", "--output", tmp_path / "run", *pace)
    # How the graph ends is not what is tested here: what it left is whole, or the next command says so.
    assert (tmp_path / "run" / "bag").is_dir(), said
    code, said = dp("replay", tmp_path / "run" / "bag", "--into", "all", "--verify")
    assert code == 0, said
    assert said.count(": identical: ") == 5, said
    # From the recorded parameters, and of every topic.
    assert "has no parameters/" not in said
    assert "not recorded" not in said
