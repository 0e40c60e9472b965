"""The drivers' node with integer codes, over real DDS: which speed is in force, in lockstep too, and what is said."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from dp_msgs.msg import ActuatorSetpoint, ThrusterCommand, ThrusterFeedback
from nav_msgs.msg import Odometry

from dp_node import from_nanoseconds, to_nanoseconds
from support.marching_thruster import drive, straight_vessel
from support.node_bench import NodeBench, node_bench
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from thruster_drivers.node import DriversNode

VESSEL = straight_vessel()
NAMES = list(VESSEL.thruster_names)
N = len(NAMES)
STEP = round(VESSEL.simulation.time_step * 1e9)  # ns
SAMPLE = round(VESSEL.measurement.sample_time * 1e9)
START = 5_000_000_000
THRUST = [20.0, 10.0, 15.0, -20.0, 5.0]
CODE, REST = drive().code_from_thrust, drive().rest_code_from_thrust


class Codes:
    """The node on its bench, and the messages to and from it."""

    def __init__(self, bench: NodeBench, hears: bool = True) -> None:
        self.bench = bench
        self.setpoints = bench.hear(ActuatorSetpoint, "actuator_setpoint")
        self.commands = bench.publisher(ThrusterCommand, "thruster_command")
        self.feedback = bench.publisher(ThrusterFeedback, "thruster_feedback")
        if hears:
            self.hear()

    def hear(self) -> None:
        self.estimates = self.bench.publisher(Odometry, "odometry")

    def command(self, stamp: int, thrust: list[float] = THRUST) -> None:
        message = ThrusterCommand(name=NAMES, thrust=thrust, azimuth=[0.0] * N)
        message.header.stamp = from_nanoseconds(stamp)
        self.answer(lambda: self.commands.publish(message))

    def estimate(self, stamp: int, surge: float, frame: str = "base_link_frd", variance: float = 0.0) -> None:
        """Publish an estimate; the node has heard it once it answers what is sent after it, or says so."""
        message = Odometry(child_frame_id=frame)
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = "map_ned"
        message.twist.twist.linear.x = surge
        message.pose.covariance[0] = variance
        heard = len(self.bench.node._surge)
        self.estimates.publish(message)
        self.bench.wait_until(lambda: len(self.bench.node._surge) > heard)

    def measure(self, stamp: int) -> ThrusterFeedback:
        message = ThrusterFeedback(name=NAMES)
        message.header.stamp = from_nanoseconds(stamp)
        for field in ("shaft_speed", "torque", "power", "azimuth", "azimuth_rate"):
            setattr(message, field, [0.0] * N)
        self.feedback.publish(message)
        return message

    def answer(self, send: Callable[[], Any]) -> ActuatorSetpoint:
        before = len(self.setpoints)
        send()
        self.bench.wait_until(lambda: len(self.setpoints) > before)
        return self.setpoints[-1]

    def at(self, stamp: int) -> list[int]:
        """Return the codes that answer a feedback."""
        answer = self.answer(lambda: self.measure(stamp))
        assert to_nanoseconds(answer.header.stamp) == stamp
        return [int(code) for code in answer.code]


@contextmanager
def codes_bench(folder: Path, **parameters: Any) -> Iterator[Codes]:
    file = folder / "vessel.yaml"
    file.write_text(yaml.safe_dump(VESSEL.model_dump(mode="json")), encoding="utf-8")
    given = {"vessel": str(file), "controller": "code_map"} | parameters
    with node_bench(DriversNode, **given) as bench:
        yield Codes(bench, given["controller"] == "code_map" and given.get("code_map__compensated", True))


def expected(speeds: list[float | None]) -> list[list[int]]:
    """Codes of the core at one feedback after the other, with these surge speeds."""
    core = Drivers(VESSEL, DriverSettings(controller="code_map"))
    return [core.step(_inputs(0.0, speed), 0.02).code.tolist() for speed in speeds]


def _inputs(age: float, speed: float | None) -> DriverInputs:
    still = np.zeros(N)
    return DriverInputs(np.array(THRUST), still, age, still, still, still, surge_speed=speed)


def test_codes_follow_the_newest_estimate_up_to_the_feedback(ros_domain_id: int, tmp_path: Path) -> None:
    with codes_bench(tmp_path) as codes:
        codes.command(START)
        assert list(codes.setpoints[-1].code) == [0] * N  # acknowledged before a feedback: nothing is asked yet
        codes.estimate(START, 1.0)
        codes.estimate(START + 10 * STEP, 2.0)
        found = [codes.at(START + k * STEP) for k in range(15)]
        assert found == expected([1.0] * 10 + [2.0] * 5)
        assert found[-1] == [CODE.code(THRUST[j], 2.0 if THRUST[j] > 0.0 else 0.0) for j in range(N)]
        said = codes.bench.diagnostics()
        assert (said["level"], said["message"]) == (0, "nominal")
        assert float(said["speed_age_s"]) == pytest.approx(0.08)
        assert said["speed_clamped"] == "0"


def test_without_an_estimate_or_with_an_old_one_codes_are_those_at_rest(ros_domain_id: int, tmp_path: Path) -> None:
    lost = "odometry is missing or stale: codes are those of the vessel at rest"
    with codes_bench(tmp_path, command_timeout=0.5) as codes:
        codes.command(START)
        speeds: list[float | None] = []
        found = []

        def sail(first: int, last: int, speed: float | None) -> None:
            for k in range(first, last):
                if k % 10 == 0:
                    codes.command(START + k * STEP)
                found.append(codes.at(START + k * STEP))
                speeds.append(speed)

        sail(1, 10, None)
        assert codes.bench.diagnostics()["message"] == lost
        codes.estimate(START + 9 * STEP, 1.5)
        sail(10, 35, 1.5)  # 0.5 s after it at the last but one
        assert codes.bench.diagnostics()["message"] == "nominal"
        sail(35, 40, None)
        said = codes.bench.diagnostics()
        assert (said["level"], said["message"]) == (1, lost)
        assert float(said["speed_age_s"]) == pytest.approx(0.6)
        codes.estimate(START + 39 * STEP, 1.5)
        sail(40, 42, 1.5)
        assert found == expected(speeds)
        assert codes.bench.diagnostics()["message"] == "nominal"


def test_a_bad_estimate_is_refused_and_the_last_good_one_kept(ros_domain_id: int, tmp_path: Path) -> None:
    with codes_bench(tmp_path) as codes:
        codes.command(START)
        codes.estimate(START, 1.0)
        found = [codes.at(START)]
        for k, (bad, reason) in enumerate(
            (
                ({"surge": math.nan}, "odometry twist.linear.x: expected a finite number, found nan"),
                ({"surge": math.inf}, "odometry twist.linear.x: expected a finite number, found inf"),
                ({"surge": 2.0, "frame": "base_link"}, "expected frame 'base_link_frd', found 'base_link'"),
            ),
            1,
        ):
            codes.estimate(START + k * STEP, **bad)
            assert reason in codes.bench.node._last_refusal
            found.append(codes.at(START + k * STEP))
        assert codes.bench.node._refused == 3
        # An observer that says it is invalid is no fault of the message.
        codes.estimate(START + 4 * STEP, 2.0, variance=-1.0)
        found.append(codes.at(START + 4 * STEP))
        assert codes.bench.node._refused == 3
        assert found == expected([1.0] * 5)


def test_a_speed_outside_the_tables_is_clamped_counted_and_said(ros_domain_id: int, tmp_path: Path) -> None:
    with codes_bench(tmp_path) as codes:
        codes.command(START)
        found = []
        for k, speed in enumerate((-0.1, 2.1, 1.0)):
            codes.estimate(START + k * STEP, speed)
            found.append(codes.at(START + k * STEP))
        assert found == expected([0.0, 2.0, 1.0])
        said = codes.bench.diagnostics()
        assert said["level"] == 1
        assert said["message"] == "the surge speed is outside the tables of a drive and is clamped: by up to 0.1 m/s"
        assert said["speed_clamped"] == "2"


def test_in_lockstep_a_feedback_waits_for_the_estimate_of_its_command(ros_domain_id: int, tmp_path: Path) -> None:
    """Whatever overtakes what: the estimate in force is that of the command in force, and no newer one."""
    with codes_bench(tmp_path, synchronous=True) as codes:
        found = [codes.at(START - STEP)]  # before the first command there is nothing to wait for
        codes.command(START)
        count = len(codes.setpoints)
        codes.measure(START)
        codes.bench.wait_until(lambda: codes.bench.node._room.holds)
        assert len(codes.setpoints) == count
        said = codes.bench.diagnostics()
        assert (said["level"], said["message"]) == (1, "thruster_feedback waits for an input: odometry")
        answer = codes.answer(lambda: codes.estimate(START, 1.0))
        assert to_nanoseconds(answer.header.stamp) == START
        found.append(list(answer.code))
        # An estimate that is ahead of the command is not looked at yet.
        codes.estimate(START + STEP, 2.0)
        found += [codes.at(START + k * STEP) for k in (1, 2)]
        # One that was refused is an answer too.
        codes.command(START + SAMPLE)
        codes.measure(START + SAMPLE)
        codes.bench.wait_until(lambda: codes.bench.node._room.holds)
        answer = codes.answer(lambda: codes.estimate(START + SAMPLE, math.nan))
        found.append(list(answer.code))
        assert found[0] == [0] * N  # held at no thrust before the first command
        # The fifth has had a longer time for the thrust rate; its speed is the last good one.
        core = Drivers(VESSEL, DriverSettings(controller="code_map"))
        core.step(_inputs(math.inf, None), 0.02)
        assert found[1:4] == [core.step(_inputs(0.0, 1.0), 0.02).code.tolist() for _ in range(3)]
        assert found[4] == core.step(_inputs(0.0, 1.0), (SAMPLE - 2 * STEP) * 1e-9).code.tolist()


def test_compensation_is_a_live_parameter(ros_domain_id: int, tmp_path: Path) -> None:
    with codes_bench(tmp_path, code_map__compensated=False) as codes:
        codes.command(START)
        assert codes.bench.node.count_subscribers("odometry") == 0
        for k in range(30):
            found = codes.at(START + k * STEP)
        assert found == [REST.code(T) for T in THRUST]
        assert "speed_clamped" not in codes.bench.diagnostics()
        assert codes.bench.set_parameters(code_map__compensated=True).successful
        codes.hear()
        codes.estimate(START + 30 * STEP, 1.0)
        assert codes.at(START + 30 * STEP) == [CODE.code(T, 1.0 if T > 0.0 else 0.0) for T in THRUST]
        # A law without codes says so by an empty array.
        assert codes.bench.set_parameters(controller="torque").successful
        assert codes.at(START + 31 * STEP) == []


def test_a_vessel_without_drives_refuses_the_law(ros_domain_id: int) -> None:
    with node_bench(DriversNode) as bench:
        result = bench.set_parameters(controller="code_map")
        assert not result.successful
        assert "expected a law without codes at thruster 'tunnel_bow', found 'code_map'" in result.reason
        assert bench.node.count_subscribers("odometry") == 0


def test_deactivation_leaves_code_0(ros_domain_id: int, tmp_path: Path) -> None:
    with codes_bench(tmp_path) as codes:
        codes.command(START)
        codes.estimate(START, 1.0)
        for k in range(10):
            assert any(codes.at(START + k * STEP)) or k == 0
        answer = codes.answer(codes.bench.node.trigger_deactivate)
        assert list(answer.code) == [0] * N
        assert list(answer.torque) == [0.0] * N
