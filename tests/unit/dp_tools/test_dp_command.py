"""`dp` refuses bad input before anything starts: one clear text, exit code 1 (2 for wrong usage)."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.dp_command import write_scenario
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]


@pytest.fixture(autouse=True)
def nothing_may_start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fail(*arguments: object, **options: object) -> None:
        raise AssertionError("a process or a ROS node was started")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("dp_bringup.processes.subprocess.Popen", fail)
    monkeypatch.setattr("dp_bringup.operator_node.rclpy.init", fail)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--scenario", "run_z"), r"error: scenario: expected a path or one of .*run_a, run_b, run_c, .*found 'run_z'"),
        (("--scenario", "my/run.yaml"), r"error: scenario: no such file: my/run\.yaml"),
        (("--vessel", "titanic"), r"error: vessel: .*cybership3.*found 'titanic'"),
        (("--scenario", "run_a", "--vessel", "titanic"), r"error: vessel: .*found 'titanic'"),
        (("--vessel", "my/ship.yaml"), r"error: .*my/ship\.yaml"),
    ],
)
def test_unknown_names(dp_here: Dp, tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    code, output = dp_here("up", *words)
    assert code == 1
    assert re.match(message, output), output
    assert len(output.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_scenario_with_errors_names_file_line_and_field_of_each(dp_here: Dp, tmp_path: Path) -> None:
    scenario = tmp_path / "bad.yaml"
    scenario.write_text(
        "name: bad\ntitle: Bad\ndescription: ''\nvessel: cybership3\nduration: 10.0\n"
        "parameters:\n  dp_controller: {mode: autopilot}\n  dp_autopilot: {gain: 1.0}\n"
        "events:\n  - {at: 0.3, setpoint: [0.0, 0.0, 0.0]}\n  - {at: 1.0, parameters: {vessel_sim: {wave: 1.0}}}\n",
        encoding="utf-8",
    )
    for words in (("up", "--scenario", scenario), ("scenario", "check", scenario)):
        code, output = dp_here(*words)
        assert code == 1
        lines = output.removeprefix("error: ").splitlines()
        assert len(lines) == 4
        for line, number, field, reason in (
            (lines[0], 10, "events.0.at", "expected a whole multiple of the sample time of 0.2 s, found 0.3"),
            (lines[1], 7, "parameters.dp_controller.mode", "found 'autopilot'"),
            (lines[2], 8, "parameters.dp_autopilot", "expected one of vessel_sim, "),
            (lines[3], 11, "events.1.parameters.vessel_sim.wave", "expected one of "),
        ):
            assert line.startswith(f"{scenario}:{number}: {field}"), line
            assert reason in line


def test_a_valid_scenario_is_told(dp_here: Dp, tmp_path: Path) -> None:
    assert dp_here("scenario", "check", write_scenario(tmp_path)) == (0, "trial: valid, 5 events in 20 s\n")
    code, output = dp_here("scenario", "list")
    assert code == 0
    assert "run_a" in output
    assert "run_b" in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("up", "--rate", "0"), "--rate 0 (no limit) needs --lockstep"),
        (("up", "--rate", "-1"), "greater than or equal to 0"),
        (("up", "--report"), "--report needs --scenario and --record"),
        (("up", "--scenario", "run_a", "--report"), "--report needs --scenario and --record"),
        (("up", "--speed", "3"), "No such option"),
        (("param", "set", "vessel_sim", "seed"), "expected NAME VALUE pairs, found an odd number of words"),
        (("frobnicate",), "No such command"),
    ],
)
def test_wrong_usage(dp_here: Dp, words: tuple[str, ...], message: str) -> None:
    code, output = dp_here(*words)
    assert code == 2
    assert message in " ".join(output.replace("│", " ").split())


def test_a_namespace_that_ros_does_not_know(dp_here: Dp) -> None:
    code, output = dp_here("up", "--namespace", "two words")
    assert (code, output) == (1, "error: namespace: expected one such as 'ship' or 'fleet/ship', found 'two words'\n")


@pytest.mark.parametrize(
    "command", ["up", "report", "topics", "param", "scenario", "design", "param set", "scenario check"]
)
def test_help_explains_every_option(dp_here: Dp, command: str) -> None:
    code, output = dp_here(*command.split(), "--help")
    assert code == 0
    assert "Usage" in output
    # Names of Python types are no help; arguments and flags of the libraries' own are theirs.
    options = output.partition("Options")[2].replace("--help        <bool>", "")
    assert "<str>" not in options
    assert "<path>" not in options


def test_a_report_of_nothing(dp_here: Dp, tmp_path: Path) -> None:
    assert dp_here("report", tmp_path / "bag") == (1, f"error: {tmp_path}/bag: no such bag\n")
