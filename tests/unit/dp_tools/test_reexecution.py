"""The present code of every node gives the messages of a recorded run again; what is not the same is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import ThrusterFeedback
from rclpy.serialization import deserialize_message, serialize_message

from dp_tools.bags.bag import open_bag
from dp_tools.in_process import ClosedLoop
from dp_tools.node_settings import ALLOCATOR, CONTROLLER, DRIVERS, OBSERVER, SIMULATOR
from dp_tools.reexecution.command import compare
from dp_tools.reexecution.comparison import TopicComparison
from dp_tools.reexecution.errors import ReexecutionError
from dp_tools.reexecution.memento import Memento
from dp_tools.reexecution.recording import Recording, recording_of
from dp_tools.reexecution.reexecute import Subject, reexecute
from dp_tools.run_bag import write_bag
from dp_tools.scenario import load_scenario
from marine_model import load_vessel
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]

# Air, lost poses, an operator who changes modes and settings, two events of one time in an order that matters.
TRIAL = """\
name: trial
title: Trial
description: Everything that a node may be fed with.
vessel: cybership3_trimmed
duration: 12.0
seed: 4
parameters:
  vessel_sim: {waves.amplitude: 0.05, waves.period: 0.9, waves.direction: 2.8, pose_dropout: 0.1}
  dp_controller: {mode: setpoint}
  thrust_allocator: {azimuth_mode: rotating}
  thruster_drivers: {controller: torque, ventilation.enabled: true}
events:
  - {at: 0.0, setpoint: [0.2, 0.1, -3.1]}
  - {at: 3.0, parameters: {thrust_allocator: {antispin.enabled: true}}}
  - {at: 4.0, setpoint: [0.6, 0.0, 0.0]}
  - {at: 4.0, setpoint: [0.4, 0.0, 0.0], parameters: {dp_controller: {transfer_time: 1.0}}}
  - {at: 6.0, parameters: {dp_controller: {mode: joystick}, vessel_sim: {waves.amplitude: 0.02}}, joystick: [1, 0.5, 0]}
  - {at: 7.0, parameters: {thruster_drivers: {controller: shaft_speed}}}
  - {at: 8.0, parameters: {dp_controller: {mode: tracking}},
     path: [{at: 8.0, position: [0.0, 0.0, 0.0]}, {at: 12.0, position: [1.0, 0.0, 0.1]}]}
"""
NODES = (OBSERVER, CONTROLLER, ALLOCATOR, DRIVERS, SIMULATOR)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trial")
    (folder / "trial.yaml").write_text(TRIAL, encoding="utf-8")
    scenario = load_scenario(folder / "trial.yaml")
    vessel = load_vessel(scenario.vessel)
    run = ClosedLoop(vessel, scenario).run()
    assert run["ventilating"].values.any()  # so that anti-spin has a say
    return write_bag(folder / "bag", run, vessel, scenario)


@pytest.fixture(scope="module")
def recording(bag: Path) -> Recording:
    with open_bag(bag) as opened:
        return recording_of(opened)


def _compared(recording: Recording, node: str, given: Any = None) -> dict[str, TopicComparison]:
    found = compare(reexecute(Subject(recording, "/", node, given or {})))
    return {one.topic: one for one in found}


@pytest.mark.parametrize("node", NODES)
def test_every_node_gives_the_recorded_messages(recording: Recording, node: str) -> None:
    found = reexecute(Subject(recording, "/", node))
    assert found.notes == []
    comparisons = compare(found)
    assert comparisons
    for one in comparisons:
        assert one.agrees, (one.topic, one.first)
        assert one.same == one.recorded == len(recording.topics[f"/{one.topic}"].messages) > 0


def test_the_bag_has_the_start_parameters_and_every_change(recording: Recording) -> None:
    names = {one.name for one in recording.attachments}
    assert {f"parameters/{node}.yaml" for node in NODES} < names
    assert len(recording.topics["/parameter_events"].messages) == 6


def test_another_setting_is_found_from_where_it_matters(recording: Recording) -> None:
    # Until 4 s the transfer time of the start holds; the switch of mode at 6 s is where it shows first.
    found = _compared(recording, CONTROLLER, {"transfer_time": 2.0})
    first = found["tau_desired"].first
    assert first is not None
    assert first.simulated == pytest.approx(6.2, abs=1e-9)
    assert 0 < found["tau_desired"].same < found["tau_desired"].recorded


def test_a_perturbed_input_is_found_at_its_place(recording: Recording) -> None:
    topic = recording.topics["/thruster_feedback"]
    place = 150  # at 3 s
    perturbed = deserialize_message(topic.messages[place].data, ThrusterFeedback)
    perturbed.shaft_speed[1] += 1e-6
    messages = list(topic.messages)
    messages[place] = replace(messages[place], data=serialize_message(perturbed))
    other = replace(recording, topics={**recording.topics, "/thruster_feedback": replace(topic, messages=messages)})
    first = _compared(other, DRIVERS)["ventilation"].first
    assert first is not None
    # The torque observer looks at the shaft speed, of its own thruster alone.
    assert (first.index, first.path) == (place, "beta_q[1]")
    assert first.simulated == pytest.approx(3.0, abs=1e-9)
    assert 0.0 < first.size < 1e-3


def test_a_changed_recorded_output_is_told_by_field_index_time_and_size(recording: Recording) -> None:
    from geometry_msgs.msg import WrenchStamped

    topic = recording.topics["/tau_achieved"]
    changed = deserialize_message(topic.messages[20].data, WrenchStamped)
    changed.wrench.force.y += 0.5
    messages = list(topic.messages)
    messages[20] = replace(messages[20], data=serialize_message(changed))
    other = replace(recording, topics={**recording.topics, "/tau_achieved": replace(topic, messages=messages)})
    found = _compared(other, ALLOCATOR)
    (difference,) = found["tau_achieved"].fields.values()
    assert (difference.path, difference.count) == ("wrench.force.y", 1)
    assert difference.first.index == 20
    assert difference.first.simulated == pytest.approx(4.0, abs=1e-9)
    # 0.5 was added to a number of some newtons.
    assert difference.first.size == pytest.approx(0.5, abs=1e-12)
    assert found["thruster_command"].agrees


def test_the_command_says_identical_or_where_it_differs(bag: Path, tmp_path: Path, dp_here: Dp) -> None:
    code, said = dp_here("replay", bag, "--into", ALLOCATOR, "--into", OBSERVER, "--verify")
    assert code == 0, said
    assert said.count("identical") == 2
    assert "AllocatorNode without middleware" in said
    new = tmp_path / "new"
    code, said = dp_here(
        "replay", bag, "--into", ALLOCATOR, "--verify", "--set", f"{ALLOCATOR}.azimuth_mode=fixed", "--output", new
    )
    assert code == 1
    assert "thrust_allocator: differs, first at 0.000 s in allocation_status, azimuth_mode" in said
    with open_bag(new) as opened:
        assert {topic.name for topic in opened.topics} == {"/thruster_command", "/tau_achieved", "/allocation_status"}
        assert len(opened.messages) == 3 * 60


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--into", "helm", "--verify"), "--into: expected all or one of"),
        (("--into", ALLOCATOR), "expected --verify, --output, or both, found neither"),
        (("--into", ALLOCATOR, "--verify", "--set", "slack=1"), "--set: expected node.parameter=value"),
        (("--into", ALLOCATOR, "--verify", "--set", f"{DRIVERS}.controller=torque"), "--set: expected a node out of"),
        (("--into", ALLOCATOR, "--verify", "--set", f"{ALLOCATOR}.slack=1"), "has no parameter slack"),
        (("--into", ALLOCATOR, "--verify", "--set", f"{ALLOCATOR}.azimuth_mode=round"), "azimuth_mode"),
        (("--into", ALLOCATOR, "--verify", "--namespace", "other"), "--namespace: expected one of /"),
    ],
)
def test_what_cannot_be_done_is_one_line(bag: Path, dp_here: Dp, words: tuple[str, ...], reason: str) -> None:
    code, said = dp_here("replay", bag, *words)
    assert code == 1
    assert reason in said
    assert "Traceback" not in said


def test_messages_of_another_definition_are_not_fed(recording: Recording) -> None:
    topic = recording.topics["/tau_desired"]
    older = replace(topic, definition=topic.definition.replace("float64 z", "float32 z"))
    other = replace(recording, topics={**recording.topics, "/tau_desired": older})
    with pytest.raises(ReexecutionError, match="/tau_desired: expected messages geometry_msgs/msg/WrenchStamped as"):
        reexecute(Subject(other, "/", ALLOCATOR))


def test_a_bag_without_parameters_falls_back_on_its_scenario_and_says_so(recording: Recording) -> None:
    older = [one for one in recording.attachments if not one.name.startswith("parameters/")]
    found = reexecute(Subject(replace(recording, attachments=older), "/", OBSERVER))
    assert any("has no parameters/dp_observer.yaml" in note for note in found.notes)
    bare = [one for one in older if one.name != "scenario.yaml"]
    with pytest.raises(ReexecutionError, match="nor a scenario: expected one of them"):
        reexecute(Subject(replace(recording, attachments=bare), "/", OBSERVER))


def test_a_memento_keeps_views_and_generators() -> None:
    class Core:
        def __init__(self) -> None:
            self.whole = np.zeros(4)
            self.part = self.whole[1:3]
            self.random = np.random.default_rng(3)
            self.words = ["a"]

    core = Core()
    kept = Memento([core], [])
    first = core.random.random()
    core.part[0] = 1.0
    core.words.append("b")
    core.extra = 1  # type: ignore[attr-defined]
    kept.restore()
    assert core.whole.tolist() == [0.0] * 4
    assert core.words == ["a"]
    assert not hasattr(core, "extra")
    assert core.random.random() == first
    core.part[0] = 2.0
    assert core.whole[1] == 2.0
