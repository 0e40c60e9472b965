"""Underwater vehicles on the node graph in lockstep: recorded, and equal to the loop without ROS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dp_tools.bag_reader import RecordedRun, read_bag
from dp_tools.limits import limits_violations
from support.dp_command import dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop

# Codes at rest, then codes for the speed, so that drivers and allocator begin to wait for odometry in mid-run; then
# another method of allocation.
TORPEDO = (
    "mmt300",
    {
        "vessel_sim": {"initial.depth": 10.0, "current.speed": 0.1},
        "dp_controller": {"mode": "semi_automatic", "joystick_timeout": 0.0, "vertical.tau_max": [12.0, 0.0, 0.0]}
        | {"axis_surge": "joystick"},
        "thrust_allocator": {"method": "portioned"},
        "thruster_drivers": {"controller": "code_map", "code_map.compensated": False},
    },
    [
        {"at": 0.0, "joystick": [60.0, 0.0, 0.0, 0.0, 0.0, 0.0]},
        {"at": 2.0, "setpoint": [0.0, 0.0, 11.0, 0.0, 0.05, 0.4]},
        {"at": 5.0, "parameters": {"thruster_drivers": {"code_map.compensated": True}}},
        {"at": 6.0, "parameters": {"thrust_allocator": {"portions.speed_limited": True}}},
        {"at": 9.0, "parameters": {"thrust_allocator": {"method": "qp"}}},
    ],
)
# Every method that the vehicle has, under way from one to the other.
SQUARE = (
    "ukwial_azimuth",
    {
        "vessel_sim": {"initial.depth": 5.0, "current.speed": 0.4, "current.direction": 2.0},
        "dp_controller": {"mode": "joystick", "joystick_timeout": 0.0},
        "thrust_allocator": {"method": "garus_azimuth"},
    },
    [
        # More across than the fixed angle of 29 deg gives, so that the propellers turn.
        {"at": 0.0, "joystick": [100.0, 400.0, 30.0, 0.0, 0.0, 0.0]},
        {"at": 3.0, "setpoint": [1.0, 1.0, 6.0, 0.0, 0.0, 0.5], "parameters": {"dp_controller": {"mode": "setpoint"}}},
        {"at": 4.0, "parameters": {"thrust_allocator": {"method": "pseudo_inverse", "feasible": "priority"}}},
        {"at": 7.0, "parameters": {"thrust_allocator": {"method": "qp", "azimuth_mode": "rotating"}}},
    ],
)


def sail(case: tuple, folder: Path, *how: str) -> RecordedRun:
    vessel, parameters, events = case
    scenario = write_scenario(folder, 12.0, events=events, parameters=parameters, vessel=vessel)
    with own_domain() as domain:
        words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(folder / "run"), *how)
        code, output = dp(*words, environment=domain)
    assert code == 0, output
    # Equal in every bit: the same cores, fed the same doubles in the same order, on one machine.
    differences = differences_from_in_process_loop(folder / "run" / "bag")
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
    return read_bag(folder / "run" / "bag")


@pytest.mark.timeout(150)
def test_a_vehicle_under_way_equals_the_loop_without_middleware(tmp_path: Path) -> None:
    recorded = sail(TORPEDO, tmp_path)
    run, vessel = recorded.run, recorded.vessel
    # So that equality means something: it sailed, dived, turned, and every part had its say.
    assert run["estimate_velocity"].values[-1, 0] > 0.5
    assert run["vertical_estimate"].values[-1, 0] > 10.05
    assert run["estimate_position"].values[-1, 2] > 0.02
    assert set(run.labels["method"].words) == {"portioned", "qp"}
    assert np.abs(run["code"].values).max() > 40
    assert run["slack"].values.shape[1] == run["tau_feasible"].values.shape[1] == len(vessel.degrees_of_freedom)
    # Codes for the speed ask more of the drives for the same thrust.
    t, code, thrust = run["code"].t, run["code"].values[:, 0], run["thrust_command"]
    before, after = np.searchsorted(t, [4.9, 5.1])
    assert code[after] - code[before] > 5
    assert abs(thrust.at(t[[after]])[0, 0] - thrust.at(t[[before]])[0, 0]) < 5.0
    assert [check for check in limits_violations(run, vessel) if check.violations] == []


@pytest.mark.timeout(150)
def test_methods_of_a_composed_graph_equal_the_loop_without_middleware(tmp_path: Path) -> None:
    recorded = sail(SQUARE, tmp_path, "--composed")
    run, vessel = recorded.run, recorded.vessel
    assert run.labels["method"].words == ("garus_azimuth", "pseudo_inverse", "qp")
    # Beside another method the program has been asked, and not beside itself.
    asked = run["tau_qp"]
    assert asked.t[-1] < 7.0
    assert len(asked.t) >= 34
    # While they turn together all four have one angle, folded into each quadrant.
    together = run["azimuth_command"].window(0.2, 4.0).values[:, :4]
    folded = np.arctan2(np.abs(np.sin(together)), np.abs(np.cos(together)))
    assert np.ptp(folded, axis=1).max() < 1e-9
    assert folded[-1, 0] > vessel.fixed_direction[0] + 0.1
    assert run["vertical_achieved"].values[:, 0].max() > 1.0
    assert [check for check in limits_violations(run, vessel) if check.violations] == []
