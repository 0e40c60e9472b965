"""The folder of a run and the parameters that it starts with."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from dp_bringup.parameter_file import read_parameter_file
from dp_tools.run_files import Pace, start_parameters, write_start_parameters
from dp_tools.run_folder import FolderError, RunFolder
from dp_tools.scenario import load_scenario
from support.repository import SCENARIOS

RING = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")


def test_a_new_folder_is_made(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "runs" / "today")
    folder.prepare(overwrite=False)
    assert [path.name for path in folder.path.iterdir()] == ["logs"]
    folder.prepare(overwrite=False)


def test_a_recording_is_kept(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    folder.bag.mkdir()
    (folder.bag / "bag_0.mcap").write_bytes(b"precious")
    with pytest.raises(FolderError, match=r"bag: holds a recording; choose another --output, or --overwrite it"):
        folder.prepare(overwrite=False)
    folder.prepare(overwrite=True)
    assert (folder.bag / "bag_0.mcap").read_bytes() == b"precious", "what goes is the recorder's to judge"


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(FolderError, match=r"file/run: cannot be written: Not a directory"):
        RunFolder(tmp_path / "file" / "run").prepare(overwrite=False)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(FolderError, match=r"cannot be written: Permission denied"):
            RunFolder(tmp_path / "run").prepare(overwrite=False)
    finally:
        tmp_path.chmod(0o700)


def test_parameters_of_a_lockstep_run_of_a_scenario(tmp_path: Path) -> None:
    scenario = load_scenario(SCENARIOS / "run_a.yaml")
    values = start_parameters("cybership3", scenario, Pace(lockstep=True, rate=0.0), hold=True)
    assert set(values) == {*RING, "vessel_sim"}
    assert {own["vessel"] for own in values.values()} == {"cybership3"}
    assert all(values[node]["synchronous"] is True for node in RING)
    assert values["vessel_sim"] == {
        "vessel": "cybership3",
        "lockstep": True,
        "rate": 0.0,
        "hold": True,
        "seed": scenario.seed,
        **scenario.parameters["vessel_sim"],
    }
    assert values["thrust_allocator"]["azimuth_mode"] == "fixed"
    folder = RunFolder(tmp_path)
    write_start_parameters(folder, values)
    assert read_parameter_file(folder.parameters) == values


def test_parameters_of_a_run_without_scenario() -> None:
    values = start_parameters("my/ship.yaml", None, Pace(lockstep=False, rate=2.0), hold=False)
    assert values["vessel_sim"] == {"vessel": "my/ship.yaml", "lockstep": False, "rate": 2.0, "hold": False}
    assert all(values[node] == {"vessel": "my/ship.yaml", "synchronous": False} for node in RING)
