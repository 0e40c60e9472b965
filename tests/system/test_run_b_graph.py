"""Run B on the graph: joystick steps with rotating thrusters, all nodes in one process."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dp_tools.bag_reader import RecordedRun, read_bag
from dp_tools.limits import limits_violations
from marine_model.frames import wrap_angles
from support.dp_command import dp, own_domain

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def run_b(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    folder: Path = tmp_path_factory.mktemp("run_b")
    with own_domain() as domain:
        code, output = dp(
            *("up", "--scenario", "run_b", "--lockstep", "--composed", "--record", "--output", folder),
            environment=domain,
        )
    assert code == 0, output
    return read_bag(folder / "bag")


def test_the_achieved_force_reaches_each_demand(run_b: RecordedRun) -> None:
    run, scenario = run_b.run, run_b.scenario
    assert scenario is not None
    steps = [(event.at, event.joystick) for event in scenario.events if event.joystick is not None]
    assert len(steps) == 13
    ends = [at for at, _ in steps[1:]] + [scenario.duration]
    for (at, joystick), end in zip(steps, ends, strict=True):
        demand = run["tau_desired"].window(at, end).values
        # A joystick demand is handed on as it is once the bumpless transfer has faded.
        assert demand[-1] == pytest.approx(joystick, abs=1e-3), at
        achieved = run["tau_achieved"].window(at, end).values
        # The second half of each step: tolerances of the scenario, 1 % of the demands.
        half = len(achieved) // 2
        assert np.all(np.abs(achieved[half:] - demand[half:]) <= (0.05, 0.05, 0.02)), at


def test_a_direction_moves_at_most_twelve_degrees_a_sample(run_b: RecordedRun) -> None:
    turn = np.abs(wrap_angles(np.diff(run_b.run["azimuth_command"].values, axis=0)))
    assert turn.shape == (1299, 4)
    # 0.21 rad, (B.27) of [Ruth], is 12.03 deg; 1e-9 for rounding of angles. They do use it.
    assert 0.2 < turn.max() <= 0.21 + 1e-9


def test_limits_are_held_and_the_allocator_finds_the_optimum_every_time(run_b: RecordedRun) -> None:
    assert [check for check in limits_violations(run_b.run, run_b.vessel) if check.violations] == []
    assert run_b.run.labels["allocation_status"].words == ("optimal",)
    assert run_b.run.labels["azimuth_mode"].words == ("rotating",)
