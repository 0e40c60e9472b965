"""Scenarios at another scale: what is scaled, what stays, and that the same ship sails the same way."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from dp_tools.figures import compute_figures
from dp_tools.in_process import ClosedLoop
from dp_tools.run_data import RunData
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.scenario_scale import scaled_scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError
from marine_model.froude import FroudeLaw
from support.repository import SCENARIOS

RATIO = 30.0

TRIAL = """\
name: trial
title: Short trial
description: Steps in waves and current.
vessel: cybership3
duration: 40.0
seed: 5
parameters:
  vessel_sim:
    waves.amplitude: 0.05
    waves.period: 0.8
    waves.direction: 2.5
    # Not a whole number of steps: at the end of a ramp that is, rounding decides on which side of it a step lies.
    waves.ramp: 1.99
    current.speed: 0.05
  dp_controller: {mode: setpoint, tau_max: [20.0, 20.0, 10.0]}
  thrust_allocator: {azimuth_mode: rotating}
events:
  - {at: 0.0, setpoint: [0.0, 0.0, 0.0]}
  - {at: 10.0, setpoint: [0.3, -0.2, 0.2]}
  - at: 20.0
    parameters:
      thrust_allocator: {thruster_enabled: [true, true, true, false], power.limit: total, power.available: 3.0}
  - {at: 30.0, path: [{at: 30.2, position: [0.3, -0.2, 0.2]}, {at: 40.0, position: [0.5, 0.0, 0.4]}]}
windows:
  whole: [0.0, 40.0]
  late: [20.0, 40.0]
figures:
  - {name: power, kind: mean_power, title: Power, window: late, thesis: 2.0, at_most: 3.0}
  - {name: ratio, kind: mean_power_change, title: Ratio, baseline: whole, compared: late, thesis: -0.4}
  - {name: north, kind: position_error, title: North, window: late, axis: north, statistic: rms, at_most: 0.5}
  - {name: heading, kind: position_error, title: Heading, window: late, axis: heading, statistic: std, at_most: 20.0}
  - name: moment
    kind: force_level
    title: Moment
    window: late
    axis: yaw
    force: tau_achieved
    statistic: mean
    at_least: -5.0
"""


@pytest.fixture(scope="module")
def model() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def ship() -> Vessel:
    return load_vessel("cybership3_full_scale")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenario") / "trial.yaml"
    path.write_text(TRIAL, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def law(model: Vessel, ship: Vessel) -> FroudeLaw:
    """Froude's law with the ratio of sample times in the place of the square root."""
    return FroudeLaw(RATIO, ship.measurement.sample_time / model.measurement.sample_time / math.sqrt(RATIO))


@pytest.fixture(scope="module")
def large(path: Path, ship: Vessel) -> Scenario:
    return load_scenario(path, ship)


def test_numbers_go_by_their_units(large: Scenario, ship: Vessel) -> None:
    sample = ship.measurement.sample_time
    near = pytest.approx
    assert large.duration == near(200 * sample, rel=1e-12)
    assert [event.at for event in large.events] == near([0.0, 50 * sample, 100 * sample, 150 * sample], rel=1e-12)
    assert large.events[1].setpoint == near((9.0, -6.0, 0.2))
    assert large.events[3].path is not None
    assert large.events[3].path[0].at == near(151 * sample, rel=1e-12)
    simulator = large.parameters["vessel_sim"]
    assert simulator["waves.amplitude"] == near(1.5)
    assert simulator["waves.period"] == near(4 * sample, rel=1e-12)
    assert simulator["waves.direction"] == 2.5
    assert simulator["current.speed"] == near(0.05 * math.sqrt(RATIO), rel=1e-8)
    # Relative errors of 1e-8 where the time step of whole ns is a factor: 0.5 ns in 0.11 s, squared.
    assert large.parameters["dp_controller"]["tau_max"] == near([540e3, 540e3, 8.1e6], rel=2e-8)
    failure = large.events[2].parameters["thrust_allocator"]
    assert failure["thruster_enabled"] == [True, True, True, False]
    assert failure["power.available"] == near(3.0 * RATIO**3.5, rel=2e-8)
    assert large.windows["late"] == near((100 * sample, 200 * sample), rel=1e-12)


def test_figures_keep_ratios_and_angles(large: Scenario) -> None:
    power, ratio, north, heading, moment = large.figures
    assert (power.thesis, power.at_most) == pytest.approx((2.0 * RATIO**3.5, 3.0 * RATIO**3.5), rel=2e-8)
    assert ratio.thesis == -0.4
    assert north.at_most == pytest.approx(15.0)
    assert heading.at_most == 20.0
    assert moment.at_least == pytest.approx(-5.0 * RATIO**4, rel=2e-8)


def test_defaults_that_are_plain_numbers_are_written_out(large: Scenario, law: FroudeLaw) -> None:
    """What a vessel file gives (time-outs of the drivers, limits of power) follows the vessel and is not."""
    assert large.parameters["dp_controller"]["anti_windup_time"] == pytest.approx(20.0 * law.time)
    assert large.parameters["dp_observer"] == {"dead_reckoning_limit": pytest.approx(5.0 * law.time)}
    for name in ("power.available", "power.bus_limit", "sectors.enabled"):
        assert name not in large.parameters["thrust_allocator"]
    assert "proportional_scale" not in large.parameters["dp_controller"]
    assert "sectors.dwell_time" not in large.parameters["thrust_allocator"]
    assert "command_timeout" not in large.parameters.get("thruster_drivers", {})


def test_it_says_what_it_is(large: Scenario, ship: Vessel) -> None:
    assert large.name == "trial_cybership3_full_scale"
    assert "trial scaled by Froude's law from 1:30 to 1:1: lengths by 30, times by 5.47723" in large.description
    assert (large.vessel, large.scale, large.path) == (ship.name, 1.0, None)


def test_written_out_it_is_a_scenario_of_its_own(large: Scenario, ship: Vessel, tmp_path: Path) -> None:
    """The recorder attaches it, and the report reads it back with the vessel that is attached too."""
    written = RunFolder(tmp_path).scenario_file(large)
    assert written.parent == tmp_path
    for found in (load_scenario(written), load_scenario(written, ship), load_scenario(written, ship, scale=False)):
        assert found.model_dump() == large.model_dump()
    assert load_scenario(written).path == written


def test_a_scenario_that_fits_is_left_alone(path: Path, model: Vessel) -> None:
    trimmed = load_vessel("cybership3_trimmed")
    for found in (load_scenario(path), load_scenario(path, model), load_scenario(path, trimmed)):
        assert found.path == path
        assert found.scale is None
        assert RunFolder(path.parent).scenario_file(found) == path


def test_a_recording_is_taken_as_it_is(path: Path, ship: Vessel) -> None:
    with pytest.raises(DocumentError, match="expected a whole multiple of the sample time"):
        load_scenario(path, ship, scale=False)


def test_a_scale_of_its_own_goes_before_that_of_its_vessel(path: Path, large: Scenario, tmp_path: Path) -> None:
    """Numbers at model scale for the ship: ``scale`` says so."""
    mine = tmp_path / "mine.yaml"
    text = path.read_text(encoding="utf-8").replace("vessel: cybership3", "vessel: cybership3_full_scale\nscale: 30.0")
    mine.write_text(text, encoding="utf-8")
    found = load_scenario(mine)
    assert found.duration == large.duration  # no other sample time is known, and so times go to whole samples
    assert found.events[1].setpoint == large.events[1].setpoint


def test_times_go_to_the_samples_of_another_ship(path: Path, model: Vessel, tmp_path: Path) -> None:
    """Its sample time, 1 s, is not that of Froude's law."""
    other = tmp_path / "other.yaml"
    other.write_text(
        "extends: cybership3_full_scale\nname: other\nsimulation: {time_step: 0.1}\nmeasurement: {sample_time: 1.0}\n",
        encoding="utf-8",
    )
    found = scaled_scenario(load_scenario(path), model, load_vessel(other))
    assert found.duration == 219.0  # 219.09
    assert [event.at for event in found.events] == [0.0, 55.0, 110.0, 164.0]
    assert found.windows["late"] == pytest.approx((20.0 * math.sqrt(RATIO), 219.0)), "no window goes beyond the end"
    assert found.parameters["vessel_sim"]["waves.period"] == pytest.approx(0.8 * math.sqrt(RATIO))


def test_runs_without_thrusters_by_name_fit_another_ship() -> None:
    assert load_scenario(SCENARIOS / "wind_and_current.yaml", load_vessel("drillship")).scale == 1.0


def test_runs_of_the_thesis_fit_the_full_scale_ship() -> None:
    for path in sorted(SCENARIOS.glob("run_*.yaml")):
        ship = load_vessel(f"{load_scenario(path).vessel}_full_scale")
        assert load_scenario(path, ship).scale == 1.0


# Sailing -------------------------------------------------------------------------------------------------------------

# Series, and the unit of each. Both scales may be 1e-6 of the largest value apart: the step of the ship is 4.6e-9
# longer than Froude's law asks for, so that forces of water and gravity, which do not go with the step, are off by
# 1e-8, and the loop makes several times that of it.
SERIES = {
    "truth_position": "m, m, rad",
    "estimate_velocity": "m/s, m/s, rad/s",
    "bias": "N, N, N m",
    "tau_desired": "N, N, N m",
    "tau_achieved": "N, N, N m",
    "thrust_command": "N",
    "azimuth_command": "rad",
    "power": "W",
    "shaft_speed": "Hz",
}
TOLERANCE = 1e-6
# Power rates and shaft speeds have peaks where thrust passes through zero: a square root of it.
LOOSER = {"power": 5e-6, "shaft_speed": 5e-6}


def differences(small: RunData, large: RunData, law: FroudeLaw) -> dict[str, float]:
    """Return the largest difference of every series over its largest value, per column, at the scale of ``small``."""
    found = {}
    for name, unit in SERIES.items():
        one, other = small[name].values, large[name].values
        assert one.shape == other.shape
        units = unit.split(",") * (one.shape[1] if "," not in unit else 1)
        apart = other / np.array([law.factor(u) for u in units]) - one
        plain = [u.strip() == "rad" for u in units]
        apart[:, plain] = (apart[:, plain] + math.pi) % (2.0 * math.pi) - math.pi
        size = np.abs(one).max(axis=0)
        found[name] = float((np.abs(apart).max(axis=0) / np.where(size > 0.0, size, 1.0)).max())
    return found


@pytest.fixture(scope="module")
def runs(path: Path, model: Vessel, ship: Vessel, large: Scenario) -> tuple[RunData, RunData]:
    return ClosedLoop(model, load_scenario(path)).run(), ClosedLoop(ship, large).run()


def test_both_scales_sail_the_same_way(runs: tuple[RunData, RunData], law: FroudeLaw) -> None:
    found = differences(*runs, law)
    too_far = {name: value for name, value in found.items() if value > LOOSER.get(name, TOLERANCE)}
    assert too_far == {}


def test_figures_agree(
    runs: tuple[RunData, RunData], path: Path, model: Vessel, ship: Vessel, large: Scenario, law: FroudeLaw
) -> None:
    small = compute_figures(runs[0], load_scenario(path), model)
    full = compute_figures(runs[1], large, ship)
    for one, other in zip(small, full, strict=True):
        assert one.value is not None
        assert other.value is not None
        assert other.value / law.factor(one.unit) == pytest.approx(one.value, rel=TOLERANCE)
