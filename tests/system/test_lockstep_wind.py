"""Lockstep in gusts and a varying current, wind feed-forward switched on and off: equal to the loop without ROS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dp_tools.bag_reader import read_bag
from support.dp_command import dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop

# On at the start; off; on again, so that the controller begins to wait for the wind in the middle of the run.
EVENTS = [
    {"at": 0.0, "setpoint": [0.0, 0.0, 0.0]},
    {"at": 3.0, "parameters": {"dp_controller": {"wind_feedforward.enabled": False}}},
    {"at": 4.0, "parameters": {"vessel_sim": {"wind.speed": 3.5, "current.variation": 0.02}}},
    {"at": 5.0, "parameters": {"dp_controller": {"wind_feedforward.enabled": True}}},
]
PARAMETERS = {
    "vessel_sim": {"wind.speed": 2.7, "wind.gusts": True, "wind.direction": 3.6, "wind.direction_variation": 0.1}
    | {"current.speed": 0.05, "current.direction": 2.0, "current.variation": 0.01, "current.time_constant": 20.0},
    "dp_controller": {"mode": "setpoint", "wind_feedforward.enabled": True},
    "thrust_allocator": {"azimuth_mode": "rotating"},
}


@pytest.mark.timeout(120)
@pytest.mark.parametrize("how", [(), ("--composed",)], ids=["separate", "composed"])
def test_graph_in_wind_equals_the_loop_without_middleware(how: tuple[str, ...], tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, 9.0, events=EVENTS, parameters=PARAMETERS)
    with own_domain() as domain:
        words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(tmp_path / "run"), *how)
        code, output = dp(*words, environment=domain)
    assert code == 0, output
    run = read_bag(tmp_path / "run" / "bag").run
    # So that equality means something: the wind blew in gusts, and feed-forward had its say before and after.
    assert run["wind"].values.std(axis=0).min() > 0.01
    acted = np.any(run["wind_feedforward"].values != 0.0, axis=1)
    assert acted[:15].all()
    assert not acted[15:25].any()
    assert acted[35:].all()
    # Equal in every bit: the same cores, fed the same doubles in the same order, on one machine.
    differences = differences_from_in_process_loop(tmp_path / "run" / "bag")
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
