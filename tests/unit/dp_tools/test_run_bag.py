"""A run sailed in process and written as a bag is read back to the bit, and its messages are whole ROS messages."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from dp_tools.bag_reader import bag_file, read_bag
from dp_tools.exact_heading import exact_quaternion
from dp_tools.in_process import ClosedLoop
from dp_tools.run_bag import write_bag
from dp_tools.run_data import Labels, RunData, Series
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel
from marine_model.frames import heading_to_quaternion, quaternion_to_heading
from marine_model.guards import FloatArray
from support.synthetic_run import synthetic_run

# Lost poses, headings beyond half a turn, words that change, sectors and anti-spin that come and go, every input.
TRIAL = """\
name: trial
title: Trial
description: Everything a bag must carry.
vessel: cybership3_trimmed
duration: 16.0
seed: 4
parameters:
  vessel_sim: {waves.amplitude: 0.03, waves.period: 0.8, pose_dropout: 0.2, initial.heading: 3.1}
  dp_controller: {mode: setpoint}
  thrust_allocator: {azimuth_mode: rotating}
events:
  - {at: 0.0, setpoint: [0.2, 0.1, -3.1]}
  - {at: 4.0, parameters: {thrust_allocator: {sectors.enabled: true, antispin.enabled: true}}}
  - {at: 8.0, parameters: {thrust_allocator: {sectors.enabled: false, antispin.enabled: false, azimuth_mode: fixed}}}
  - {at: 9.0, parameters: {dp_controller: {mode: joystick}}, joystick: [1.0, 0.5, 0.1]}
  - {at: 12.0, parameters: {dp_controller: {mode: tracking}},
     path: [{at: 12.0, position: [0.0, 0.0, 0.0]}, {at: 16.0, position: [1.0, 0.0, 0.1]}]}
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    path = tmp_path_factory.mktemp("scenario") / "trial.yaml"
    path.write_text(TRIAL, encoding="utf-8")
    return load_scenario(path)


@pytest.fixture(scope="module")
def vessel(scenario: Scenario) -> Vessel:
    return load_vessel(scenario.vessel)


@pytest.fixture(scope="module")
def run(vessel: Vessel, scenario: Scenario) -> RunData:
    return ClosedLoop(vessel, scenario).run()


@pytest.fixture(scope="module")
def bag(run: RunData, vessel: Vessel, scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("run") / "bag", run, vessel, scenario)


def _assert_equal(found: RunData, expected: RunData) -> None:
    assert found.info == expected.info
    assert found.thrusters == expected.thrusters
    assert set(found.series) == set(expected.series)
    for name, series in expected.series.items():
        assert np.array_equal(found.series[name].t, series.t), name
        assert np.array_equal(found.series[name].values, series.values, equal_nan=True), name
    assert set(found.labels) == set(expected.labels)
    for name, labels in expected.labels.items():
        assert found.labels[name].words == labels.words, name
        assert np.array_equal(found.labels[name].t, labels.t), name


def _as_stamped(t: FloatArray) -> FloatArray:
    return np.rint(t * 1e9) * 1e-9


def test_the_run_comes_back_to_the_bit(bag: Path, run: RunData) -> None:
    # So that equality means something.
    assert 0 < np.isnan(run["pose"].values[:, 0]).sum() < len(run["pose"].t)
    assert run.labels["azimuth_mode"].words == ("rotating", "fixed")
    assert 0 < len(run["torque_loss"].t) < len(run["pose"].t)
    assert 0 < len(run["crossing"].t) < len(run["pose"].t)
    _assert_equal(read_bag(bag).run, run)


def test_a_run_with_every_series_comes_back_too(tmp_path: Path) -> None:
    vessel = load_vessel("cybership3")
    made_up = synthetic_run(vessel, duration=210.0)
    # Stamps are whole nanoseconds.
    series = {name: Series(_as_stamped(one.t), one.values) for name, one in made_up.series.items()}
    labels = {name: Labels(_as_stamped(one.t), one.words) for name, one in made_up.labels.items()}
    made_up = replace(made_up, series=series, labels=labels)
    _assert_equal(read_bag(write_bag(tmp_path / "bag", made_up, vessel, None)).run, made_up)


def test_the_bag_says_what_was_sailed(bag: Path, vessel: Vessel, scenario: Scenario) -> None:
    recorded = read_bag(bag)
    assert recorded.vessel.model_dump() == vessel.model_dump()
    assert recorded.scenario is not None
    assert recorded.scenario.model_dump() == scenario.model_dump()


def test_another_seed_is_in_the_scenario_of_the_bag(
    run: RunData, vessel: Vessel, scenario: Scenario, tmp_path: Path
) -> None:
    other = scenario.model_copy(update={"seed": 11})
    write_bag(tmp_path / "bag", replace(run, info=replace(run.info, seed=11)), vessel, other)
    recorded = read_bag(tmp_path / "bag")
    assert recorded.scenario is not None
    assert (recorded.scenario.seed, recorded.run.info.seed) == (11, 11)


def test_every_message_is_one_of_rosbags_own(bag: Path) -> None:
    """Each is read by rosbags with the schema in the file, and serialized by it to the same bytes."""
    counts: Counter[str] = Counter()
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            again = bytes(reader.typestore.serialize_cdr(message, connection.msgtype))
            assert again == bytes(raw), connection.topic
            counts[connection.topic] += 1
    samples, feedbacks = 80, 800
    at_sample = (
        "truth", "propulsion_truth", "wind", "pose", "odometry", "observer_state", "tau_desired", "controller_status",
        "thruster_command", "tau_achieved", "allocation_status",
    )  # fmt: skip
    at_feedback = ("thruster_feedback", "actuator_setpoint", "ventilation", "clock")
    expected = {f"/{name}": samples for name in at_sample} | {f"/{name}": feedbacks for name in at_feedback}
    # The operator changed parameters of two nodes, twice each.
    assert counts == expected | {"/setpoint": 1, "/joystick": 1, "/path": 1, "/parameter_events": 4}


def test_messages_say_what_nodes_say(bag: Path, vessel: Vessel) -> None:
    found: dict[str, list[Any]] = {}
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            found.setdefault(connection.topic, []).append(reader.deserialize(raw, connection.msgtype))
    status = found["/allocation_status"]
    assert [message.antispin for message in status] == [20 <= i < 40 for i in range(80)]
    assert {len(message.torque_loss) for message in status} == {len(vessel.thrusters)}
    assert all(math.isnan(message.demanded_power) for message in status)
    lost = [message for message in found["/pose"] if message.pose.covariance[0] < 0.0]
    assert 0 < len(lost) < 80
    assert found["/pose"][0].header.frame_id == found["/odometry"][0].header.frame_id == "map_ned"
    assert found["/odometry"][0].child_frame_id == "base_link_frd"
    assert tuple(found["/thruster_feedback"][0].name) == vessel.thruster_names
    # The command in force is that of the last sample.
    stamps = [m.command_stamp.sec * 5 + m.command_stamp.nanosec // 200_000_000 for m in found["/actuator_setpoint"]]
    assert stamps == [k // 10 for k in range(800)]
    (path,) = found["/path"]
    assert [pose.pose.position.x for pose in path.poses] == [0.0, 1.0]
    (joystick,) = found["/joystick"]
    assert (joystick.wrench.force.x, joystick.wrench.torque.z, joystick.header.stamp.sec) == (1.0, 0.1, 9)


def test_messages_are_in_the_order_in_which_they_travel(bag: Path) -> None:
    with bag_file(bag).open("rb") as stream:
        found = [(c.topic, m.log_time) for _, c, m in make_reader(stream).iter_messages(log_time_order=False)]
    times = [time for _, time in found]
    assert times == sorted(times)
    assert len(set(times)) == len(times)  # a player that sorts by time keeps the order
    topics = [topic for topic, _ in found]
    chain = ["/pose", "/odometry", "/tau_desired", "/thruster_command", "/thruster_feedback", "/actuator_setpoint"]
    assert [topics.index(topic) for topic in chain] == sorted(topics.index(topic) for topic in chain)


def test_metadata_is_that_of_a_rosbag2_bag(bag: Path) -> None:
    information = yaml.safe_load((bag / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    with bag_file(bag).open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert information["message_count"] == summary.statistics.message_count
    for topic in information["topics_with_message_count"]:
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
        assert topic["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"


def test_it_needs_no_middleware() -> None:
    import subprocess
    import sys

    code = (
        "import sys; sys.modules['rclpy'] = None; sys.modules['rcl_interfaces'] = None\n"
        "import dp_tools.campaign.sail, dp_tools.campaign.workers, dp_tools.campaign.page, dp_tools.report"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True).stderr == ""


@given(st.floats(-math.pi, math.pi))
def test_every_heading_has_a_quaternion_that_gives_it_back(heading: float) -> None:
    z, w = exact_quaternion(heading)
    # Below the smallest normal number half of it is not exact.
    if abs(heading) > 1e-300:
        assert quaternion_to_heading(0.0, 0.0, z, w) == heading
    _, _, z_plain, w_plain = heading_to_quaternion(heading)
    # Within the units in the last place that were looked at, of numbers up to one.
    assert abs(z - z_plain) < 3e-15
    assert abs(w - w_plain) < 3e-15
