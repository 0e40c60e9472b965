"""Ventilation, anti-spin and pitch on the graph: as in the loop without middleware, and each time the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from dp_tools.bag_reader import read_bag
from dp_tools.report import report_bag
from support.dp_command import DpProcess, dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop, messages_by_topic, repeatable
from support.repository import SCENARIOS
from support.thruster_rig import controllable_pitch_vessel

PORT = 2  # azimuth_port

pytestmark = pytest.mark.timeout(300)


def sail(scenario: Path, folder: Path, *options: str) -> Path:
    """Sail ``scenario`` in lockstep; return its bag."""
    with own_domain() as domain:
        words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(folder), *options)
        code, output = dp(*words, environment=domain)
    assert code == 0, output
    return folder / "bag"


def short_run_c(folder: Path, **fields: Any) -> Path:
    """Run C with its switches at 8, 10 and 12 s instead of 200, 260 and 320 s, which ends at 14 s.

    The port thruster draws air from 7 s on.
    """
    content = yaml.safe_load((SCENARIOS / "run_c.yaml").read_text(encoding="utf-8"))
    for section in ("windows", "close_ups", "plots", "figures"):
        del content[section]
    content["duration"] = 14.0
    content["events"] = content["events"][:4]
    for event, at in zip(content["events"], (0.0, 8.0, 10.0, 12.0), strict=True):
        event["at"] = at
    path = folder / "short_run_c.yaml"
    path.write_text(yaml.safe_dump(content | fields), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def run_c(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Bag of the short Run C, sailed by one process."""
    folder = tmp_path_factory.mktemp("run_c")
    return sail(short_run_c(folder), folder / "one", "--composed")


def test_antispin_switched_on_off_and_on_is_the_same_without_middleware(run_c: Path) -> None:
    """Equal in every bit. A demand after a switch uses what the drivers told before it."""
    differences = differences_from_in_process_loop(run_c)
    assert {"ventilating", "beta_q", "beta_q2", "torque_loss", "pitch_ratio"} < set(differences)
    assert {name: value for name, value in differences.items() if value != 0.0} == {}


def test_the_bag_of_run_c_has_ventilation_that_antispin_acts_on(run_c: Path) -> None:
    """So that equality means something; and the report of it shows ventilation."""
    recorded = read_bag(run_c)
    series = recorded.run.series
    flags = series["ventilating"]
    assert flags.values.any(axis=0).tolist() == [False, False, True, True]
    assert series["beta_q"].values.min() < 0.9
    assert len(flags.t) == len(series["beta_q2"].t) == len(series["shaft_speed"].t) == 700
    # Told while anti-spin is on, and until what it has learnt is forgotten.
    told = series["torque_loss"]
    assert told.t[0] == pytest.approx(8.0)
    on, off, again = (told.values[(told.t > start - 0.1) & (told.t < start + 1.9), PORT] for start in (8.0, 10.0, 12.0))
    assert on.min() < 0.9
    assert np.all(np.diff(off) > 0.0)
    assert again.min() < off.max()
    page, _ = report_bag(run_c, run_c.parent)
    text = page.read_text(encoding="utf-8")
    assert "ventilat" in text.lower()


def test_run_c_in_five_processes_sends_the_same_bytes(run_c: Path, tmp_path: Path) -> None:
    separate, composed = messages_by_topic(sail(short_run_c(tmp_path), tmp_path / "five")), messages_by_topic(run_c)
    topics = repeatable(separate)
    assert "/ventilation" in topics
    assert topics == repeatable(composed)
    assert [topic for topic in topics if separate[topic] != composed[topic]] == []


LAWS = [
    {"at": 0.0, "setpoint": [0.3, 0.2, 0.1]},
    {"at": 3.0, "parameters": {"thruster_drivers": {"controller": "shaft_speed_pitch"}}},
    {"at": 6.0, "parameters": {"thruster_drivers": {"controller": "torque,power,torque_pitch,pitch"}}},
]


def test_laws_of_pitch_switched_while_running_are_the_same_without_middleware(tmp_path: Path) -> None:
    vessel = controllable_pitch_vessel()
    (tmp_path / "pitch.yaml").write_text(yaml.safe_dump(vessel.model_dump(mode="json")), encoding="utf-8")
    scenario = write_scenario(tmp_path, 9.0, vessel="pitch.yaml", events=LAWS)
    bag = sail(scenario, tmp_path / "run", "--composed")
    differences = differences_from_in_process_loop(bag)
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
    pitch = read_bag(bag).run["pitch_ratio"]
    assert np.ptp(pitch.values[pitch.t < 3.0], axis=0).tolist() == [0.0] * 4
    assert np.ptp(pitch.values[pitch.t > 3.0], axis=0).min() > 0.1


def test_a_ring_that_waits_for_ventilation_names_it(tmp_path: Path) -> None:
    """A vessel whose drivers detect nothing: a sensor outside might, so that the allocator does not refuse."""
    vessel = controllable_pitch_vessel().model_dump(mode="json")
    vessel["drivers"]["ventilation"] = None
    (tmp_path / "deaf.yaml").write_text(yaml.safe_dump(vessel), encoding="utf-8")
    switched_on = {"thrust_allocator": {"antispin.enabled": True}}
    scenario = write_scenario(tmp_path, 5.0, vessel="deaf.yaml", parameters=switched_on, events=[])
    log = tmp_path / "run" / "logs" / "vessel_sim.log"
    with own_domain() as domain, DpProcess(
        "up", "--scenario", scenario, "--lockstep", "--output", tmp_path / "run", environment=domain
    ) as process:  # fmt: skip
        process.wait_until(
            lambda: log.exists() and "nobody publishes ventilation" in log.read_text(encoding="utf-8"),
            "the simulator says what it waits for",
            timeout=120.0,
        )
        process.children()
    assert "lockstep at 0.200 s" in log.read_text(encoding="utf-8")
