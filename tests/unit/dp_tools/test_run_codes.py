"""A run of a vehicle whose drives take codes: in process, in its bag, and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from dp_tools.bag_reader import read_bag
from dp_tools.in_process import ClosedLoop
from dp_tools.run_bag import write_bag
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario
from marine_model import load_vessel

VESSEL = load_vessel("mmt300")


def sailed(controller: str, compensated: bool = True) -> tuple[RunData, Scenario]:
    """Eight seconds ahead from rest."""
    scenario = Scenario.model_validate(
        {
            "name": "codes",
            "title": "codes",
            "description": "a step ahead",
            "vessel": "mmt300",
            "duration": 8.0,
            "seed": 1,
            "windows": {"all": [0.0, 8.0]},
            "parameters": {
                "dp_controller": {"mode": "setpoint"},
                "thruster_drivers": {"controller": controller, "code_map.compensated": compensated},
            },
            "events": [{"at": 0.0, "label": "ahead", "setpoint": [20.0, 0.0, 0.0, 0.0, 0.0, 0.0]}],
        }
    )
    return ClosedLoop(VESSEL, scenario).run(), scenario


def test_codes_are_logged_written_and_read(tmp_path: Path) -> None:
    run, scenario = sailed("code_map")
    codes = run["code"]
    assert codes.values.shape == (400, 5)
    assert (codes.values == np.rint(codes.values)).all()
    assert codes.values[-1, 2:4].min() > 30.0  # the side thrusters push ahead
    back = read_bag(write_bag(tmp_path / "bag", run, VESSEL, scenario)).run
    np.testing.assert_array_equal(back["code"].t, codes.t)
    np.testing.assert_array_equal(back["code"].values, codes.values)


def test_the_speed_that_the_drivers_use_is_the_estimate() -> None:
    """With it the codes are those at rest until the vehicle moves, and larger for the same thrust then."""
    (compensated, _), (without, _) = sailed("code_map"), sailed("code_map", compensated=False)
    drive = VESSEL.thrusters[2].drive
    assert drive is not None
    maps = drive.build(VESSEL.propeller_models[2], VESSEL.density)
    # Thrust moves by 84 N/s at most: the reference is the command once that has stood for a sample.
    k = len(compensated["thrust_command"].t) - 1
    thrust, surge = compensated["thrust_command"].values[k, 2], compensated["estimate_velocity"].values[k, 0]
    assert surge > 0.3
    code = maps.code(thrust, surge * VESSEL.thrusters[2].plane[0][0])
    assert compensated["code"].values[-1, 2] == code
    assert code > maps.code(thrust, None) + 5
    thrust = without["thrust_command"].values[k, 2]
    assert without["code"].values[-1, 2] == maps.code(thrust, None)


def test_a_law_without_codes_leaves_the_series_out(tmp_path: Path) -> None:
    run, scenario = sailed("torque")
    assert "code" not in run
    assert "code" not in read_bag(write_bag(tmp_path / "bag", run, VESSEL, scenario)).run
