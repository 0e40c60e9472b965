"""The closed loop in process: order of the ring, repeatability, events, and that the vessel is held."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dp_tools.figures import compute_figures
from dp_tools.in_process import ClosedLoop
from dp_tools.limits import limits_violations
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from support.repository import SCENARIOS


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


def trial(duration: float = 10.0, **fields: Any) -> Scenario:
    content: dict[str, Any] = {
        "name": "trial",
        "title": "Trial",
        "description": "",
        "vessel": "cybership3",
        "duration": duration,
        "seed": 1,
        "parameters": {"dp_controller": {"mode": "setpoint"}},
    }
    return Scenario.model_validate(content | fields)


def sail(vessel: Vessel, scenario: Scenario) -> RunData:
    return ClosedLoop(vessel, scenario).run()


@pytest.fixture(scope="module")
def run_a(vessel: Vessel) -> tuple[Scenario, RunData]:
    scenario = load_scenario(SCENARIOS / "run_a.yaml")
    return scenario, sail(vessel, scenario)


@pytest.fixture(scope="module")
def run_b(vessel: Vessel) -> tuple[Scenario, RunData]:
    scenario = load_scenario(SCENARIOS / "run_b.yaml")
    return scenario, sail(vessel, scenario)


def test_antispin_without_anybody_who_tells_of_ventilation_is_refused(vessel: Vessel) -> None:
    """On the graph an external sensor may; here there is none."""
    document = vessel.model_dump()
    document["drivers"]["ventilation"] = None
    event = {"at": 1.0, "parameters": {"thrust_allocator": {"antispin.enabled": True}}}
    with pytest.raises(
        InputError, match=r"at 1\.000 s: thrust_allocator waits for ventilation, which nobody publishes"
    ):
        ClosedLoop(Vessel.model_validate(document), trial(2.0, events=[event])).run()


# Order and time ------------------------------------------------------------------------------------------------------


class Watched:
    """Stands before a core and notes when which method is called, and with what."""

    def __init__(self, core: Any, name: str, calls: list[tuple[str, str, tuple[Any, ...]]]) -> None:
        self._core, self._name, self._calls = core, name, calls

    def __getattr__(self, attribute: str) -> Any:
        found = getattr(self._core, attribute)
        if attribute not in ("step", "measure"):
            return found

        def call(*arguments: Any) -> Any:
            self._calls.append((self._name, attribute, arguments))
            return found(*arguments)

        return call


def test_order_of_the_ring(vessel: Vessel) -> None:
    loop = ClosedLoop(vessel, trial(0.4))
    calls: list[tuple[str, str, tuple[Any, ...]]] = []
    for name in ("simulator", "observer", "controller", "allocator", "drivers"):
        setattr(loop, f"_{name}", Watched(getattr(loop, f"_{name}"), name, calls))
    loop.run()
    sample = [("simulator", "measure"), ("observer", "step"), ("controller", "step"), ("allocator", "step")]
    tick = [("drivers", "step"), ("simulator", "step")]
    assert [call[:2] for call in calls] == (sample + tick * 10) * 2
    ages = [arguments[0].command_age for name, _, arguments in calls if name == "drivers"]
    assert ages == pytest.approx([k * 0.02 for k in range(10)] * 2)


def test_answer_of_the_allocator_is_used_at_the_next_sample(vessel: Vessel) -> None:
    loop = ClosedLoop(vessel, trial(0.6, events=[{"at": 0.0, "setpoint": [1.0, 0.0, 0.0]}]))
    calls: list[tuple[str, str, tuple[Any, ...]]] = []
    loop._observer = Watched(loop._observer, "observer", calls)  # type: ignore[assignment]
    loop._controller = Watched(loop._controller, "controller", calls)  # type: ignore[assignment]
    run = loop.run()
    expected = [np.zeros(3), *run["tau_achieved"].values[:-1]]
    for name, field in (("observer", "tau"), ("controller", "tau_achieved")):
        found = [getattr(arguments[0], field) for who, _, arguments in calls if who == name]
        assert np.array_equal(np.array(found), np.array(expected))
    assert np.any(run["tau_achieved"].values)


def test_series_begin_at_zero_at_both_rates(vessel: Vessel) -> None:
    run = sail(vessel, trial(2.0))
    assert run["pose"].t == pytest.approx(np.arange(10) * 0.2)
    assert run["power"].t == pytest.approx(np.arange(100) * 0.02)
    for name, series in run.series.items():
        assert np.isfinite(series.values).all(), name
    assert run.info.simulated_time == pytest.approx(2.0)
    assert run.info.how == "in process"
    assert run.info.real_time_factor is not None


def test_run_is_repeatable_to_the_bit_and_the_seed_matters(vessel: Vessel) -> None:
    waves = {"vessel_sim": {"waves.amplitude": 0.05, "waves.period": 0.9}, "dp_controller": {"mode": "setpoint"}}
    first, second = (sail(vessel, trial(20.0, parameters=waves)) for _ in range(2))
    for name, series in first.series.items():
        assert np.array_equal(series.values, second[name].values, equal_nan=True), name
    other = sail(vessel, trial(20.0, parameters=waves, seed=2))
    assert not np.array_equal(first["pose"].values, other["pose"].values)


def test_progress_is_told(vessel: Vessel) -> None:
    told: list[float] = []
    ClosedLoop(vessel, trial(30.0)).run(told.append)
    assert told == pytest.approx([0.0, 10.0, 20.0])


# Events --------------------------------------------------------------------------------------------------------------


def test_event_holds_from_its_sample_on(vessel: Vessel) -> None:
    events = [
        {"at": 0.0, "joystick": [1.0, 0.0, 0.0]},
        {"at": 2.0, "joystick": [0.0, 0.5, 0.0]},
        {"at": 4.0, "parameters": {"thrust_allocator": {"azimuth_mode": "rotating"}}},
    ]
    parameters = {"dp_controller": {"mode": "joystick", "joystick_timeout": 0.0, "transfer_time": 0.0}}
    run = sail(vessel, trial(6.0, parameters=parameters, events=events))
    demand = run["tau_desired"]
    assert np.array_equal(demand.window(0.2, 2.0).values, np.tile([1.0, 0.0, 0.0], (9, 1)))
    assert np.array_equal(demand.window(2.0, 6.0).values, np.tile([0.0, 0.5, 0.0], (20, 1)))
    assert run.labels["azimuth_mode"].words == ("fixed", "rotating")
    assert run.labels["azimuth_mode"].t == pytest.approx([0.0, 4.0])


def test_heading_of_a_setpoint_goes_the_shorter_way(vessel: Vessel) -> None:
    """From 3.1 to -3.1 rad is a turn of 0.083 rad through south."""
    parameters = {"dp_controller": {"mode": "setpoint"}, "vessel_sim": {"initial.heading": 3.1}}
    run = sail(vessel, trial(40.0, parameters=parameters, events=[{"at": 0.0, "setpoint": [0.0, 0.0, -3.1]}]))
    turned = np.array([wrap_angle(h - math.pi) for h in run["estimate_position"].values[:, 2]])
    assert np.abs(turned).max() < 0.1
    # Sensor noise is 0.001 rad; ten of that.
    assert wrap_angle(float(run["estimate_position"].values[-1, 2]) + 3.1) == pytest.approx(0.0, abs=0.01)


def test_path_is_followed(vessel: Vessel) -> None:
    path = [{"at": 2.0, "position": [0.0, 0.0, 0.0]}, {"at": 42.0, "position": [1.0, 0.0, 0.0]}]
    parameters = {"dp_controller": {"mode": "tracking"}}
    run = sail(vessel, trial(70.0, parameters=parameters, events=[{"at": 0.0, "path": path}]))
    assert run["truth_position"].values[-1, 0] == pytest.approx(1.0, abs=0.02)  # m; 2 % of the way


def test_refused_event_says_when(vessel: Vessel) -> None:
    scenario = trial(4.0, events=[{"at": 2.0, "parameters": {"thrust_allocator": {"thruster_enabled": [True]}}}])
    with pytest.raises(InputError, match=r"at 2\.0 s: thruster_enabled: expected 4 elements"):
        sail(vessel, scenario)


def test_refused_start_parameters(vessel: Vessel) -> None:
    with pytest.raises(InputError, match=r"node: expected one of vessel_sim, .*found 'dp_control'"):
        ClosedLoop(vessel, trial(parameters={"dp_control": {"mode": "setpoint"}}))
    with pytest.raises(InputError, match=r"parameter: expected one of mode, .*found 'mood'"):
        ClosedLoop(vessel, trial(parameters={"dp_controller": {"mood": "setpoint"}}))


# The runs of the thesis ----------------------------------------------------------------------------------------------


def test_run_a_saves_power_with_rotating_thrusters(run_a: tuple[Scenario, RunData], vessel: Vessel) -> None:
    scenario, run = run_a
    figures = {figure.spec.name: figure for figure in compute_figures(run, scenario, vessel)}
    saving = figures["mean_power_rotating_over_fixed"]
    assert saving.high is not None
    assert saving.high < 0.0
    # Power is c |T|^(3/2), (3.11). A steady surge force F takes F / sqrt(2) from each aft thruster while they point to
    # +-45 deg; rotating, all three azimuth thrusters point ahead with shares that cost least without a yaw moment.
    assert saving.value == pytest.approx(steady_surge_saving(vessel), abs=0.01)  # sensor noise keeps all four busy
    # The mean surge force holds the drift force on average, whatever the directions of the thrusters.
    fixed, rotating = (figures[f"surge_force_mean_{name}"].value for name in ("fixed", "rotating"))
    assert fixed is not None
    assert rotating == pytest.approx(fixed, rel=0.02)  # the interval of either is below 1 %


def steady_surge_saving(vessel: Vessel) -> float:
    power = vessel.propellers.power_per_thrust_3_2
    fixed = (power[2] + power[3]) * math.sqrt(0.5) ** 1.5
    # Minimum of |W_u T|^2, (4.10), with T_2 + T_3 + T_4 = 1 and T_3 = T_4 (equal arms, opposite sides).
    _, bow, port, starboard = vessel.allocator.thrust_weight
    aft = 1.0 / (2.0 + (port**2 + starboard**2) / (2.0 * bow**2))
    shares = np.array([0.0, 1.0 - 2.0 * aft, aft, aft])
    return float((power * shares**1.5).sum()) / float(fixed) - 1.0


def test_run_a_holds_position(run_a: tuple[Scenario, RunData]) -> None:
    """Once the integral has settled: within a hundredth of the length and a degree of the set point, with waves."""
    _, run = run_a
    settled = run["truth_position"].window(100.0, 380.0).values
    assert np.abs(settled[:, :2]).max() < 0.02
    assert np.degrees(np.abs(settled[:, 2]).max()) < 1.0


def test_run_b_reaches_every_demand(run_b: tuple[Scenario, RunData], vessel: Vessel) -> None:
    scenario, run = run_b
    figures = {figure.spec.name: figure for figure in compute_figures(run, scenario, vessel)}
    longest = figures["time_to_demand_max"].value
    assert longest is not None
    # A turn of 180 deg takes 3 s at 1.05 rad/s; a second such turn may follow, as the thrusters pass one another.
    assert longest < 6.5


@pytest.mark.parametrize("name", ["run_a", "run_b"])
def test_limits_are_held_in_every_sample(name: str, vessel: Vessel, request: pytest.FixtureRequest) -> None:
    _, run = request.getfixturevalue(name)
    broken = [check for check in limits_violations(run, vessel) if check.violations]
    assert broken == []


@pytest.mark.parametrize("name", ["run_a", "run_b"])
def test_direction_moves_at_most_twelve_degrees_a_sample(name: str, request: pytest.FixtureRequest) -> None:
    _, run = request.getfixturevalue(name)
    azimuth = run["azimuth_command"].values
    turn = np.abs([[wrap_angle(float(a)) for a in row] for row in np.diff(azimuth, axis=0)])
    # 0.21 rad, (B.27); rounding of the angle on top.
    assert turn.max() <= 0.21 + 1e-9


@pytest.mark.parametrize("name", ["run_a", "run_b"])
def test_every_core_stays_nominal(name: str, request: pytest.FixtureRequest) -> None:
    _, run = request.getfixturevalue(name)
    assert run.labels["allocation_status"].words == ("optimal",)
    assert run.labels["controller_status"].words == ("nominal",)
    assert run.labels["observer_status"].words == ("initialised", "nominal")


def test_scenario_of_another_vessel(tmp_path: Path) -> None:
    """A loop runs on any vessel file, here with the lever arms of chapter 7."""
    other = load_vessel("cybership3_ch7")
    run = sail(other, trial(20.0, events=[{"at": 0.0, "setpoint": [0.3, 0.0, 0.1]}]))
    assert run.info.vessel == "cybership3_ch7"
    assert run["truth_position"].values[-1, 0] > 0.1
