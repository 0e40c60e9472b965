"""Section `power` of a vessel file: available power and buses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import DocumentError


def ship(folder: Path, power: str) -> Path:
    path = folder / "ship.yaml"
    path.write_text(f"extends: cybership3\nname: ship\npower: {power}\n", encoding="utf-8")
    return path


def test_cybership_is_split_as_7_6_3_concludes() -> None:
    for name in ("cybership3", "cybership3_ch7"):
        vessel = load_vessel(name)
        np.testing.assert_array_equal(vessel.bus_members, [[1, 0, 1, 0], [0, 1, 0, 1]])  # 13 | 24
        np.testing.assert_array_equal(vessel.bus_limit, [math.inf, math.inf])  # none is printed
        assert vessel.power_available == math.inf


def test_limits_are_read_and_frozen(tmp_path: Path) -> None:
    vessel = load_vessel(ship(tmp_path, "{available: 30.0, buses: [{name: bus_b, limit: 12.0}]}"))
    assert vessel.power_available == 30.0
    np.testing.assert_array_equal(vessel.bus_limit, [math.inf, 12.0])
    for array in (vessel.bus_members, vessel.bus_limit):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_without_buses(tmp_path: Path) -> None:
    vessel = load_vessel(ship(tmp_path, "{buses: []}"))
    assert vessel.bus_members.shape == (0, 4)
    assert vessel.bus_limit.shape == (0,)


def test_a_thruster_may_be_on_no_bus(tmp_path: Path) -> None:
    vessel = load_vessel(ship(tmp_path, "{buses: [{name: bus_b, thrusters: [azimuth_bow]}]}"))
    np.testing.assert_array_equal(vessel.bus_members, [[1, 0, 1, 0], [0, 1, 0, 0]])


@pytest.mark.parametrize(
    ("power", "problem"),
    [
        (
            "{buses: [{name: bus_b, thrusters: [azimuth_bow, rudder]}]}",
            "power.buses.1.thrusters.1: expected one of tunnel_bow, azimuth_bow, azimuth_port, azimuth_starboard, "
            "found 'rudder'",
        ),
        (
            "{buses: [{name: bus_b, thrusters: [azimuth_bow, azimuth_port]}]}",
            "power.buses.1.thrusters.1: 'azimuth_port' is on 'bus_a' already",
        ),
        (
            "{buses: [{name: bus_b, thrusters: [azimuth_bow, azimuth_bow]}]}",
            "power.buses.1.thrusters.1: 'azimuth_bow' is on 'bus_b' already",
        ),
        ("{buses: [{name: bus_b, thrusters: []}]}", "power.buses.1.thrusters: Tuple should have at least 1 item"),
        ("{buses: [{name: bus_b, limit: 0.0}]}", "power.buses.1.limit: Input should be greater than 0, found 0.0"),
        ("{buses: [{name: bus_b, limit: -2.0}]}", "power.buses.1.limit: Input should be greater than 0, found -2.0"),
        ("{buses: [{name: bus_b, limit: .inf}]}", "power.buses.1.limit: Input should be a finite number, found inf"),
        ("{available: 0.0}", "power.available: Input should be greater than 0, found 0.0"),
        ("{buses: [{name: Bus B, thrusters: [azimuth_bow]}]}", "power.buses.2.name: String should match pattern"),
        ("{generators: 2}", "power.generators: Extra inputs are not permitted"),
    ],
)
def test_what_is_refused(tmp_path: Path, power: str, problem: str) -> None:
    path = ship(tmp_path, power)
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    assert f"{path}:3: {problem}" in str(caught.value)


def test_two_buses_of_one_name(tmp_path: Path) -> None:
    # Written whole: lists of an extended file are merged by name, where a name twice is refused before.
    path = tmp_path / "ship.yaml"
    base = (Path(load_vessel.__code__.co_filename).parent / "vessels" / "cybership3.yaml").read_text(encoding="utf-8")
    path.write_text(base.replace("name: bus_b", "name: bus_a"), encoding="utf-8")
    with pytest.raises(DocumentError, match=r"power\.buses\.1\.name: every name must be unique, found 'bus_a' twice"):
        load_vessel(path)
