"""Scenario files: what is accepted, and that every error names file, line and field."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import pytest
import yaml

from dp_bringup.workspace import WorkspaceError
from dp_tools.figures import AnyFigure
from dp_tools.node_settings import default_settings
from dp_tools.scenario import free_run, load_scenario, scenario_names
from marine_model import load_vessel
from marine_model.errors import DocumentError, UnknownNameError
from support.repository import ROOT, SCENARIOS

MINIMAL = """\
name: trial
title: A trial
description: Nothing but a trial.
vessel: cybership3
duration: 20.0
parameters:
  dp_controller: {mode: setpoint}
events:
  - at: 0.0
    setpoint: [0.0, 0.0, 0.0]
  - at: 10.0
    parameters:
      thrust_allocator: {azimuth_mode: rotating}
windows:
  late: [12.0, 20.0]
figures:
  - name: power
    kind: mean_power
    title: Mean power
    window: late
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "trial.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def problem(folder: Path, text: str) -> str:
    with pytest.raises(DocumentError) as error:
        load_scenario(write(folder, text))
    return str(error.value)


def line_of(text: str, part: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


def test_minimal_scenario(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, MINIMAL))
    assert scenario.run == "trial"
    assert scenario.path == tmp_path / "trial.yaml"
    assert scenario.events[1].parameters == {"thrust_allocator": {"azimuth_mode": "rotating"}}
    assert scenario.figures[0].kind == "mean_power"


@pytest.mark.parametrize(("name", "run"), [("run_a", "a"), ("run_b", "b")])
def test_scenarios_of_the_thesis_are_valid(name: str, run: str) -> None:
    scenario = load_scenario(SCENARIOS / f"{name}.yaml")
    assert scenario.run == run
    assert scenario.name == name
    assert scenario.source.startswith("[Ruth]")


def test_run_a_is_the_thesis_run() -> None:
    scenario = load_scenario(SCENARIOS / "run_a.yaml")
    settings: Any = scenario.settings(load_vessel(scenario.vessel))
    waves = settings["vessel_sim"].waves
    assert (waves.amplitude, waves.period) == (0.06, 0.8)  # Table C.1
    start, end = scenario.windows["fixed"]
    assert end - start == 100.0  # 4.5.1
    assert scenario.figures[0].name == "mean_power_rotating_over_fixed"
    assert scenario.figures[0].thesis == -0.44


def test_start_parameters_hold_the_seed(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, MINIMAL.replace("duration", "seed: 7\nduration")))
    assert scenario.start_parameters["vessel_sim"]["seed"] == 7
    settings: Any = scenario.settings(load_vessel("cybership3"))
    assert settings["vessel_sim"].seed == 7
    assert settings["dp_controller"].mode == "setpoint"
    assert settings["thruster_drivers"] == default_settings(load_vessel("cybership3"))["thruster_drivers"]


@pytest.mark.parametrize(
    ("old", "new", "line", "expected"),
    [
        ("duration: 20.0", "duration: soon", "duration", "duration: Input should be a valid number, found 'soon'"),
        ("duration: 20.0", "duration: -1.0", "duration", "duration: Input should be greater than 0, found -1.0"),
        ("duration: 20.0\n", "", "name:", "duration: Field required"),
        (
            "duration: 20.0",
            "duration: 20.0\ncolour: red",
            "colour",
            "colour: Extra inputs are not permitted, found 'red'",
        ),
        (
            "duration: 20.0",
            "duration: 20.1",
            "duration",
            "expected a whole multiple of the sample time of 0.2 s, found 20.1",
        ),
        (
            "at: 10.0",
            "at: 10.1",
            "at: 10.1",
            "events.1.at: expected a whole multiple of the sample time of 0.2 s, found 10.1",
        ),
        ("at: 10.0", "at: 40.0", "at: 40.0", "events.1.at: expected a time within the duration of 20.0 s, found 40.0"),
        ("at: 0.0", "at: 12.0", "at: 10.0", "events.1.at: expected events in order of time, found 10.0 after 12.0"),
        (
            "    setpoint: [0.0, 0.0, 0.0]",
            "    setpoint: [0.0, 0.0]",
            "    setpoint: [",
            "events.0.setpoint.2: Field required",
        ),
        (
            "    setpoint: [0.0, 0.0, 0.0]",
            "    setpoint: [0.0, 0.0, .nan]",
            "    setpoint: [",
            "events.0.setpoint.2: Input should be a finite number, found nan",
        ),
        (
            "    setpoint: [0.0, 0.0, 0.0]",
            "    setpoint: [0.0, 0.0, 0.0]\n    joystick: [1.0, 0.0, 0.0]",
            "at: 0.0",
            "expected at most one of setpoint, joystick and path, found ['setpoint', 'joystick']",
        ),
        (
            "    setpoint: [0.0, 0.0, 0.0]\n",
            "",
            "at: 0.0",
            "expected parameters, setpoint, joystick or path, found none of them",
        ),
        (
            "    setpoint: [0.0, 0.0, 0.0]",
            "    path: [{at: 1.0, position: [0.0, 0.0, 0.0]}, {at: 1.0, position: [1.0, 0.0, 0.0]}]",
            "at: 0.0",
            "path: expected times that increase, found [1.0, 1.0]",
        ),
        (
            "thrust_allocator: {",
            "thrust_alocator: {",
            "thrust_alocator",
            "events.1.parameters.thrust_alocator: expected one of vessel_sim, dp_observer, dp_controller, "
            "thrust_allocator, thruster_drivers, found 'thrust_alocator'",
        ),
        ("azimuth_mode: rotating", "azimuth_mod: rotating", "azimuth_mod:", "found 'azimuth_mod'"),
        (
            "azimuth_mode: rotating",
            "azimuth_mode: sideways",
            "azimuth_mode",
            "events.1.parameters.thrust_allocator.azimuth_mode: azimuth_mode: Input should be 'fixed', "
            "'rotating', 'variable' or 'auto', found 'sideways'",
        ),
        (
            "dp_controller: {mode: setpoint}",
            "dp_controller: {mode: 3}",
            "dp_controller",
            "parameters.dp_controller.mode",
        ),
        (
            "dp_controller: {mode: setpoint}",
            "vessel_sim: {waves.amplitude: -0.1}",
            "vessel_sim",
            "parameters.vessel_sim.waves.amplitude: waves.amplitude: Input should be greater than or equal to 0, "
            "found -0.1",
        ),
        (
            "dp_controller: {mode: setpoint}",
            "vessel_sim: {waves.amplitude: 0.2, waves.period: 0.8}",
            "vessel_sim",
            "waves.amplitude and waves.period: expected height over length at most 1/7",
        ),
        (
            "dp_controller: {mode: setpoint}",
            "vessel_sim: {seed: 3}",
            "vessel_sim",
            "parameters.vessel_sim.seed: the seed is the scenario's own field 'seed'",
        ),
        (
            "thrust_allocator: {azimuth_mode: rotating}",
            "vessel_sim: {initial.north: 1.0}",
            "initial.north",
            "events.1.parameters.vessel_sim.initial.north: cannot change while the node runs; set it under parameters",
        ),
        (
            "late: [12.0, 20.0]",
            "late: [12.0, 20.2]",
            "late: [",
            "windows.late: expected 0 <= start < end <= 20.0, found [12.0, 20.2]",
        ),
        ("late: [12.0, 20.0]", "late: [12.0, 12.0]", "late: [", "windows.late: expected 0 <= start < end <= 20.0"),
        (
            "window: late",
            "window: early",
            "window: early",
            "figures.0.window: expected a name out of windows (late), found 'early'",
        ),
        (
            "kind: mean_power",
            "kind: mean_powr",
            "- name: power",
            "figures.0: Input tag 'mean_powr' found using 'kind' does not match",
        ),
        ("    window: late\n", "", "- name: power", "figures.0.window: Field required"),
        (
            "figures:\n",
            "figures:\n  - {name: power, kind: limit_violation_count, title: Violations}\n",
            "- name: power",
            "figures.1.name: every name must be unique, found 'power' twice",
        ),
        ("vessel: cybership3", "vessel: titanic", "vessel", "vessel: vessel: expected a path or one of cybership3"),
        ("name: trial", "name: Trial!", "name", "name: String should match pattern"),
    ],
)
def test_error_names_file_line_and_field(tmp_path: Path, old: str, new: str, line: str, expected: str) -> None:
    assert old in MINIMAL
    text = MINIMAL.replace(old, new, 1)
    message = problem(tmp_path, text)
    assert expected in message
    assert f"{tmp_path / 'trial.yaml'}:{line_of(text, line)}: " in message


def test_every_problem_is_reported_at_once(tmp_path: Path) -> None:
    message = problem(tmp_path, MINIMAL.replace("at: 10.0", "at: 10.1").replace("window: late", "window: early"))
    assert len(message.splitlines()) == 2


def test_settings_that_are_only_wrong_together_are_blamed_on_the_node(tmp_path: Path) -> None:
    alone = "dp_controller: {mode: setpoint}"
    # 0.2 m breaks at the default period of 1 s too; 0.1 m does not, nor does a period of 0.8 s without waves.
    assert "parameters.vessel_sim.waves.amplitude: " in problem(
        tmp_path, MINIMAL.replace(alone, "vessel_sim: {waves.amplitude: 0.2, waves.period: 0.8}")
    )
    assert "parameters.vessel_sim: waves: waves.amplitude and waves.period" in problem(
        tmp_path, MINIMAL.replace(alone, "vessel_sim: {waves.amplitude: 0.1, waves.period: 0.8}")
    )


def test_vessel_file_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("extends: cybership3\nname: mine\n", encoding="utf-8")
    scenario = load_scenario(write(tmp_path, MINIMAL.replace("vessel: cybership3", "vessel: mine.yaml")))
    assert load_vessel(scenario.vessel).name == "mine"


def test_given_vessel_is_used_instead_of_the_one_named(tmp_path: Path) -> None:
    path = write(tmp_path, MINIMAL.replace("vessel: cybership3", "vessel: elsewhere"))
    assert load_scenario(path, load_vessel("cybership3")).vessel == "elsewhere"


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"scenario: no such file: .*nowhere\.yaml"):
        load_scenario(tmp_path / "nowhere.yaml")


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An install prefix whose ament index holds dp_bringup with two scenarios."""
    index = tmp_path / "share" / "ament_index" / "resource_index" / "packages"
    folder = tmp_path / "share" / "dp_bringup" / "scenarios"
    index.mkdir(parents=True)
    folder.mkdir(parents=True)
    (index / "dp_bringup").touch()
    for name in ("zigzag", "anchor"):
        (folder / f"{name}.yaml").write_text(MINIMAL.replace("name: trial", f"name: {name}"), encoding="utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    return tmp_path


@pytest.mark.usefixtures("workspace")
def test_names_come_from_the_ament_index() -> None:
    assert scenario_names() == ("anchor", "zigzag")
    assert load_scenario("zigzag").name == "zigzag"


@pytest.mark.usefixtures("workspace")
def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="expected a path or one of anchor, zigzag, found 'zagzig'"):
        load_scenario("zagzig")


def test_without_a_built_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    with pytest.raises(WorkspaceError, match="dp_bringup: not in the ament index"):
        scenario_names()


def test_run_without_scenario_measures_nothing() -> None:
    scenario = free_run("cybership3", 12.3)
    assert scenario.duration == 12.3
    assert scenario.figures == ()
    assert scenario.events == ()


def test_scenario_files_are_plain_yaml() -> None:
    """No tag or anchor that another YAML 1.2 reader would not take."""
    for path in sorted(SCENARIOS.glob("*.yaml")):
        assert isinstance(yaml.safe_load(path.read_text(encoding="utf-8")), dict)


def test_example_of_the_documentation_is_valid(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    example = text.partition("```yaml\n")[2].partition("```")[0]
    scenario = load_scenario(write(tmp_path, example))
    assert scenario.name == "my_trial"
    assert [event.at for event in scenario.events] == [0.0, 60.0]


def test_every_kind_of_figure_is_documented() -> None:
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    kinds = [get_args(spec.model_fields["kind"].annotation)[0] for spec in get_args(get_args(AnyFigure)[0])]
    assert len(kinds) >= 40
    for kind in kinds:
        assert f"| `{kind}` |" in text


def test_every_number_of_the_thesis_has_a_reason_why_ours_may_differ() -> None:
    """A figure that differs without one is an open question that nobody sees."""
    names = sorted(path.stem for path in SCENARIOS.glob("run_?.yaml"))
    assert names == [f"run_{letter}" for letter in "abcdefghijk"]
    for name in names:
        for figure in load_scenario(SCENARIOS / f"{name}.yaml").figures:
            assert figure.thesis is None or figure.reason, (name, figure.name)
