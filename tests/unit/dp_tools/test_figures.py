"""Figures of merit on signals whose answers are known."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dp_tools.figures import AnyFigure, Figure, compute_figures, write_figures
from dp_tools.figures.joystick import TimeToDemand, times_to_demand
from dp_tools.limits import limits_violations
from dp_tools.run_data import RunData, Series
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.signals import averaged, low_frequency_truth, measured_force, position_error
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError, InputError
from support.repository import SCENARIOS
from support.synthetic_run import POWER, SAMPLE, synthetic_run


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario(SCENARIOS / "run_a.yaml")


@pytest.fixture(scope="module")
def run(vessel: Vessel) -> RunData:
    return synthetic_run(vessel)


@pytest.fixture(scope="module")
def figures(run: RunData, scenario: Scenario, vessel: Vessel) -> dict[str, Figure]:
    return {figure.spec.name: figure for figure in compute_figures(run, scenario, vessel)}


def with_series(run: RunData, **series: Series) -> RunData:
    return dataclasses.replace(run, series={**run.series, **series})


def measuring(*specs: dict[str, Any], events: tuple[dict[str, Any], ...] = ()) -> Scenario:
    return Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": "cybership3",
            "duration": 380.0,
            "events": list(events),
            "windows": {"steps": [20.0, 60.0], "part": [100.0, 200.0]},
            "figures": list(specs),
        }
    )


def test_mean_power_and_its_change(figures: dict[str, Figure], vessel: Vessel) -> None:
    n = len(vessel.thrusters)
    # The ripple does not fit the window to a whole number of periods: 0.2 / (7.85 * 100 s) of the mean at most.
    tolerance = 2.0 * 0.2 / 785.0
    assert figures["mean_power_fixed"].value == pytest.approx(n * POWER["fixed"], rel=tolerance)
    assert figures["mean_power_fixed"].unit == "W"
    change = figures["mean_power_rotating_over_fixed"]
    assert change.value == pytest.approx(POWER["rotating"] / POWER["fixed"] - 1.0, abs=tolerance)
    assert change.unit == "1"
    assert change.low is not None
    assert change.high is not None
    assert change.value is not None
    assert change.low < change.value < change.high
    assert change.difference == pytest.approx(change.value + 0.44)


def test_position_error_is_that_of_the_estimate(figures: dict[str, Figure], run: RunData) -> None:
    estimate = run["estimate_position"].window(100.0, 200.0).values
    assert figures["north_error_std_fixed"].value == pytest.approx(float(estimate[:, 0].std()))
    heading = figures["heading_error_std_fixed"]
    assert heading.unit == "deg"
    assert heading.value == pytest.approx(math.degrees(float(estimate[:, 2].std())))


def test_extremes_and_counts_have_no_interval(figures: dict[str, Figure]) -> None:
    for name in ("north_error_max_switch", "azimuth_step_max", "limit_violations"):
        assert figures[name].low is None
        assert figures[name].high is None


def test_heading_error_does_not_jump_at_south(run: RunData) -> None:
    t = np.arange(3.0)
    turned = with_series(
        run,
        estimate_position=Series(t, np.array([[0.0, 0.0, math.pi - 0.01]] * 3)),
        reference_position=Series(t, np.array([[0.0, 0.0, -math.pi + 0.01]] * 3)),
    )
    assert position_error(turned, "estimate_position").values[:, 2] == pytest.approx([-0.02] * 3)


def test_thrust_levels_are_of_magnitudes(run: RunData, vessel: Vessel) -> None:
    t = np.arange(100.0, 220.0)
    thrust = np.where(t < 150.0, -2.0, 3.0)[:, None] * np.array([0.0, 0.0, 1.0, 0.0])
    changed = with_series(run, thrust_command=Series(t, thrust))
    change = {"name": "c", "kind": "thrust_level_change", "title": "C", "thruster": "azimuth_port"}
    specs = (
        {"name": "l", "kind": "thrust_level", "title": "L", "window": "before", "thruster": "azimuth_port"},
        {**change, "baseline": "before", "compared": "after"},
    )
    trial = measuring(*specs).model_copy(update={"windows": {"before": (100.0, 150.0), "after": (150.0, 200.0)}})
    level, ratio = compute_figures(changed, trial, vessel)
    assert (level.value, level.unit) == (2.0, "N")
    assert (ratio.value, ratio.unit) == (0.5, "1")


def test_share_of_time_in_which_a_thruster_ventilates(run: RunData, vessel: Vessel) -> None:
    share = {"kind": "ventilating_share", "title": "S", "window": "part"}
    one, other = compute_figures(
        run,
        measuring(
            {**share, "name": "one", "thruster": "azimuth_port"},
            {**share, "name": "other", "thruster": "azimuth_starboard"},
        ),
        vessel,
    )
    assert one.value == pytest.approx(0.1)  # a second in ten
    assert other.value == 0.0


def test_a_jump_is_what_the_command_moves_beyond_the_demand(run: RunData, vessel: Vessel) -> None:
    t = np.arange(100.0, 105.0)
    desired = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    achieved = desired + np.array([[0.0], [-0.5], [0.25], [0.0], [0.0]])  # moves by 0.5, 0.75, 0.25, 0
    changed = with_series(run, tau_desired=Series(t, desired), tau_achieved=Series(t, achieved))
    specs = [
        {"name": kind, "kind": kind, "title": "T", "window": "part", "axis": "surge"}
        for kind in ("force_deviation", "force_jump")
    ]
    deviation, jump = compute_figures(changed, measuring(*specs), vessel)
    assert (deviation.value, deviation.unit) == (0.5, "N")
    assert jump.value == 0.75  # from 0.5 to 1.25 while the demand stood still


def test_a_thruster_of_a_figure_must_be_there(tmp_path: Path) -> None:
    text = (SCENARIOS / "run_a.yaml").read_text(encoding="utf-8")
    extra = "  - {name: x, kind: thrust_level, title: X, window: fixed, thruster: rudder}\n"
    path = tmp_path / "x.yaml"
    path.write_text(text.replace("figures:\n", f"figures:\n{extra}", 1), encoding="utf-8")
    with pytest.raises(DocumentError, match=r"thruster: expected one of tunnel_bow, .*, found 'rudder'"):
        load_scenario(path)


def test_azimuth_step_goes_the_shorter_way(run: RunData, vessel: Vessel) -> None:
    t = np.array([0.0, 0.2])
    azimuth = Series(t, np.array([[0.0, math.pi - 0.1, 0.0, 0.0], [0.0, -math.pi + 0.05, 0.0, 0.0]]))
    spec = {"name": "step", "kind": "azimuth_step", "title": "Step"}
    (figure,) = compute_figures(with_series(run, azimuth_command=azimuth), measuring(spec), vessel)
    assert figure.value == pytest.approx(math.degrees(0.15))


def test_force_tracking_is_measured_minus_commanded(run: RunData, vessel: Vessel) -> None:
    measured = measured_force(run, vessel)
    commanded = Series(run["tau_achieved"].t, np.zeros((len(run["tau_achieved"].t), 3)))
    spec = {"name": "t", "kind": "force_tracking", "title": "T", "window": "part", "axis": "yaw"}
    (figure,) = compute_figures(with_series(run, tau_achieved=commanded), measuring(spec), vessel)
    expected = math.sqrt(float((measured.window(100.0, 200.0).values[:, 2] ** 2).mean()))
    assert figure.value == pytest.approx(expected)
    assert figure.unit == "N m"


STEPS = (
    {"at": 20.0, "joystick": [1.0, 0.0, 0.0]},
    {"at": 40.0, "joystick": [-1.0, 0.0, 0.0]},
)
REACHED = {"name": "t", "kind": "time_to_demand", "title": "T", "window": "steps", "tolerance": [0.05, 0.05, 0.02]}


def stepped(run: RunData, achieved_surge: np.ndarray) -> RunData:
    t = np.arange(400) * SAMPLE
    desired = np.zeros((400, 3))
    desired[:, 0] = np.where(t < 20.0 - 1e-6, 0.0, np.where(t < 40.0 - 1e-6, 1.0, -1.0))
    achieved = desired.copy()
    achieved[:, 0] = achieved_surge
    return with_series(run, tau_desired=Series(t, desired), tau_achieved=Series(t, achieved))


def spec_of(scenario: Scenario) -> TimeToDemand:
    spec: AnyFigure = scenario.figures[0]
    assert isinstance(spec, TimeToDemand)
    return spec


def test_time_to_demand(run: RunData, vessel: Vessel) -> None:
    """Reached at once; then after 3 s, with one sample within tolerance on the way that does not count."""
    t = np.arange(400) * SAMPLE
    surge = np.where(t < 20.0 - 1e-6, 0.0, np.where(t < 40.0 - 1e-6, 1.0, 0.5))
    surge[t > 43.0 - 1e-6] = -0.96
    surge[round(41.0 / SAMPLE)] = -1.0
    scenario = measuring(REACHED, events=STEPS)
    data = stepped(run, surge)
    assert times_to_demand(spec_of(scenario), data, scenario) == ((20.0, 0.0), (40.0, 3.0))
    (figure,) = compute_figures(data, scenario, vessel)
    assert figure.value == 3.0


def test_demand_that_is_not_reached_has_no_time(run: RunData, vessel: Vessel) -> None:
    scenario = measuring(REACHED, events=STEPS)
    data = stepped(run, np.zeros(400))
    assert times_to_demand(spec_of(scenario), data, scenario) == ((20.0, None), (40.0, None))
    (figure,) = compute_figures(data, scenario, vessel)
    assert figure.value is None
    assert figure.difference is None


def test_bound_is_judged(run: RunData, vessel: Vessel) -> None:
    spec = {"name": "step", "kind": "azimuth_step", "title": "Step"}
    for bound, held in ((90.0, True), (0.0, False)):
        (figure,) = compute_figures(run, measuring(spec | {"at_most": bound}), vessel)
        assert figure.held is held
    (figure,) = compute_figures(run, measuring(spec), vessel)
    assert figure.held is None


def test_missing_series_is_named(run: RunData, scenario: Scenario, vessel: Vessel) -> None:
    bare = dataclasses.replace(run, series={"pose": run["pose"]})
    with pytest.raises(InputError, match="series: expected one of pose, found 'power'"):
        compute_figures(bare, scenario, vessel)


def test_window_that_the_run_does_not_reach_is_named(run: RunData, scenario: Scenario, vessel: Vessel) -> None:
    short = with_series(run, power=run["power"].window(0.0, 100.0))
    with pytest.raises(InputError, match="window: expected at least 20 samples, found 0"):
        compute_figures(short, scenario, vessel)


def test_figures_json(tmp_path: Path, run: RunData, scenario: Scenario, vessel: Vessel) -> None:
    figures = compute_figures(run, scenario, vessel)
    write_figures(tmp_path / "figures.json", scenario, figures)
    document = json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))
    assert document["run"] == "a"
    assert [entry["name"] for entry in document["figures"]] == [spec.name for spec in scenario.figures]
    for entry in document["figures"]:
        assert set(entry) == {"name", "value", "unit", "thesis", "low", "high"}
    first = document["figures"][0]
    assert first["name"] == "mean_power_rotating_over_fixed"
    assert first["thesis"] == -0.44
    assert first["low"] < first["value"] < first["high"]


# Limits --------------------------------------------------------------------------------------------------------------


def test_limits_are_held_by_the_synthetic_run(run: RunData, vessel: Vessel) -> None:
    checks = limits_violations(run, vessel)
    assert {check.limit for check in checks} == {
        "thrust",
        "thrust_rate",
        "azimuth_rate",
        "torque",
        "azimuth_motor_rate",
    }
    assert len(checks) == 5 * len(vessel.thrusters)
    assert sum(check.violations for check in checks) == 0


@pytest.mark.parametrize(
    ("series", "limit", "thruster", "value"),
    [
        ("thrust_command", "thrust", 1, 8.8),
        ("thrust_command", "thrust", 2, -10.2),
        ("torque_setpoint", "torque", 3, 0.2),
        ("azimuth_rate_setpoint", "azimuth_motor_rate", 0, 0.1),
        ("thrust_command", "thrust", 1, math.nan),
    ],
)
def test_one_sample_outside_is_found(
    run: RunData, vessel: Vessel, series: str, limit: str, thruster: int, value: float
) -> None:
    values = run[series].values.copy()
    values[50, thruster] = value
    checks = limits_violations(with_series(run, **{series: Series(run[series].t, values)}), vessel)
    bad = [check for check in checks if check.limit == limit and check.violations]
    assert [check.thruster for check in bad] == [vessel.thruster_names[thruster]]
    assert bad[0].violations == 1
    assert bad[0].first == pytest.approx(run[series].t[50])


def test_rates_are_of_successive_samples(run: RunData, vessel: Vessel) -> None:
    """A turn of 0.22 rad in one sample of 0.2 s breaks 1.05 rad/s; 0.20 rad does not, through south either."""
    t = np.array([0.0, 0.2, 0.4])
    azimuth = np.zeros((3, 4))
    azimuth[:, 1] = [math.pi - 0.1, -math.pi + 0.1, -math.pi + 0.32]
    thrust = np.zeros((3, 4))
    thrust[:, 2] = [0.0, 2.7, 5.5]  # 13.5 N/s allows 2.7 N
    data = dataclasses.replace(run, series={"thrust_command": Series(t, thrust), "azimuth_command": Series(t, azimuth)})
    found = {(c.limit, c.thruster): c for c in limits_violations(data, vessel)}
    assert found["azimuth_rate", "azimuth_bow"].violations == 1
    assert found["azimuth_rate", "azimuth_bow"].first == pytest.approx(0.4)
    assert found["thrust_rate", "azimuth_port"].violations == 1
    assert found["thrust_rate", "azimuth_port"].first == pytest.approx(0.4)
    assert sum(c.violations for c in found.values()) == 2


# Signals -------------------------------------------------------------------------------------------------------------


def test_measured_force_is_that_of_the_configuration(run: RunData, vessel: Vessel) -> None:
    """One newton ahead from the port thruster alone: surge 1 N, yaw -L_y = 0.11 N m."""
    speed = np.zeros((1, 4))
    speed[0, 2] = math.sqrt(1.0 / float(vessel.propellers.thrust_per_speed_squared[2]))
    t = np.zeros(1)
    data = dataclasses.replace(run, series={"shaft_speed": Series(t, speed), "azimuth": Series(t, np.zeros((1, 4)))})
    assert measured_force(data, vessel).values[0] == pytest.approx([1.0, 0.0, 0.11])


def test_averages_begin_at_their_first_sample() -> None:
    series = Series(np.arange(7) * 0.1, np.arange(7.0)[:, None])
    means = averaged(series, 0.3)
    assert means.t == pytest.approx([0.0, 0.3])
    assert means.values[:, 0] == pytest.approx([1.0, 4.0])


def test_truth_without_waves(run: RunData, vessel: Vessel) -> None:
    """Waves of 0.8 s vanish; a slow swing of 60 s stays within 1 %; a turn through south does no harm."""
    t = np.arange(2000) * SAMPLE
    slow = np.sin(2.0 * math.pi * t / 60.0)
    waves = 0.5 * np.sin(2.0 * math.pi * t / 0.8)
    heading = np.angle(np.exp(1j * (math.pi + 0.1 * slow)))
    data = with_series(run, truth_position=Series(t, np.column_stack([slow + waves, waves, heading])))
    smooth = low_frequency_truth(data, vessel).values[50:-50]
    assert smooth[:, 0] == pytest.approx(slow[50:-50], abs=0.01)
    assert smooth[:, 1] == pytest.approx(0.0, abs=1e-3)
    assert np.abs(np.diff(smooth[:, 2])).max() < 0.01


def test_series_windows_and_holds() -> None:
    series = Series(np.array([0.0, 0.2, 0.2 * 2, 0.2 * 3]), np.arange(4.0)[:, None])
    # 0.2 * 3 is 0.6000000000000001: a window that ends at 0.6 leaves it out, one that begins there has it.
    assert series.window(0.2, 0.6).values[:, 0].tolist() == [1.0, 2.0]
    assert series.window(0.6, 1.0).values[:, 0].tolist() == [3.0]
    held = series.at(np.array([-0.1, 0.0, 0.3, 9.0]))[:, 0]
    assert math.isnan(held[0])
    assert held[1:].tolist() == [0.0, 1.0, 3.0]


def test_run_data_refuses_what_does_not_fit(run: RunData) -> None:
    t = np.arange(3.0)
    for name, series, message in (
        ("posse", Series(t, np.zeros((3, 3))), "series: expected one of pose, .*found 'posse'"),
        ("pose", Series(t, np.zeros((3, 2))), r"series pose: expected shape \(3, 3\), found \(3, 2\)"),
        ("power", Series(t, np.zeros((3, 5))), r"series power: expected shape \(3, 4\), found \(3, 5\)"),
        ("pose", Series(t[::-1], np.zeros((3, 3))), "series pose: expected increasing time"),
    ):
        with pytest.raises(InputError, match=message):
            with_series(run, **{name: series})
