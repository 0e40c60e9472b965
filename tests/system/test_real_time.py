"""The graph by the wall clock."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from dp_tools.bag_reader import read_bag
from support.dp_command import dp, write_scenario
from support.recordings import messages_by_topic

pytestmark = [pytest.mark.timeout(200), pytest.mark.usefixtures("ros_domain_id")]


def test_five_times_real_time(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, 10.0, events=[{"at": 0.0, "setpoint": [0.1, 0.0, 0.0]}])
    code, output = dp("up", "--scenario", scenario, "--rate", "5", "--record", "--output", tmp_path / "run")
    assert code == 0, output
    assert re.search(r"sailed +10 s of trial in [\d.]+ s", output)
    run = read_bag(tmp_path / "run" / "bag").run
    # 10 s at five times real time are 2 s. Not less: the wall clock paces. Not much more: a loaded machine may be late,
    # but a pace that is not kept to at all (1, 2.5 ...) takes 4 s and more.
    assert 1.9 < run.info.wall_time < 4.0
    # All 500 steps were made, each with a stamp of its own.
    assert np.array_equal(np.round(run["power"].t / 0.02), np.arange(500))
    found = messages_by_topic(tmp_path / "run" / "bag")
    expected = {
        *("pose", "truth", "odometry", "observer_state", "controller_status", "tau_desired", "tau_achieved"),
        *("thruster_command", "allocation_status", "actuator_setpoint", "thruster_feedback", "environment_force"),
        *("setpoint", "clock", "diagnostics"),
    }
    assert {f"/{name}" for name in expected} <= set(found)
