"""The controller's node over real DDS: what it answers, refuses, and says to the operator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path as PathOnDisk
from typing import Any

import numpy as np
import pytest
import yaml
from dp_msgs.msg import ControllerStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry, Path

from dp_controller import Controller, ControllerInputs, ControllerSettings
from dp_controller.node import ControllerNode
from dp_node import from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME, MAP_FRAME, heading_to_quaternion
from support.node_bench import NodeBench, node_bench

VESSEL = load_vessel("cybership3")
START = 1_700_000_000_000_000_000  # ns
STEP = 200_000_000


def pose_into(pose: Any, position: Any) -> None:
    q = pose.orientation
    pose.position.x, pose.position.y = float(position[0]), float(position[1])
    q.x, q.y, q.z, q.w = heading_to_quaternion(float(position[2]))


def odometry(k: int, position: Any = (0.0, 0.0, 0.0), velocity: Any = (0.0, 0.0, 0.0), valid: bool = True) -> Odometry:
    message = Odometry(child_frame_id=BODY_FRAME)
    message.header.frame_id = MAP_FRAME
    message.header.stamp = from_nanoseconds(START + k * STEP)
    pose_into(message.pose.pose, position)
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.angular.z = (float(v) for v in velocity)
    if not valid:
        message.pose.covariance[0] = -1.0
    return message


def wrench(stamp: int, tau: Any, frame: str = BODY_FRAME) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = frame
    message.header.stamp = from_nanoseconds(stamp)
    message.wrench.force.x, message.wrench.force.y, message.wrench.torque.z = (float(v) for v in tau)
    return message


def wind_at(k: int, ahead: float, starboard: float, frame: str = BODY_FRAME) -> Vector3Stamped:
    message = Vector3Stamped()
    message.header.frame_id = frame
    message.header.stamp = from_nanoseconds(START + k * STEP)
    message.vector.x, message.vector.y = ahead, starboard
    return message


def setpoint(position: Any, stamp: int = 0, frame: str = MAP_FRAME) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = frame
    message.header.stamp = from_nanoseconds(stamp)
    pose_into(message.pose, position)
    return message


def path(times: Any, positions: Any, frame: str = MAP_FRAME) -> Path:
    message = Path()
    message.header.frame_id = frame
    for time, position in zip(times, positions, strict=True):
        pose = PoseStamped()
        pose.header.stamp = from_nanoseconds(START + round(time * 1e9))
        pose_into(pose.pose, position)
        message.poses.append(pose)
    return message


def vector(message: WrenchStamped) -> list[float]:
    return [message.wrench.force.x, message.wrench.force.y, message.wrench.torque.z]


class Ring:
    """The controller's node, and a probe that plays observer, allocator and operator."""

    def __init__(self, bench: NodeBench) -> None:
        self.bench = bench
        self.odometry = bench.publisher(Odometry, "odometry")
        self.achieved = bench.publisher(WrenchStamped, "tau_achieved")
        self.setpoint = bench.publisher(PoseStamped, "setpoint")
        self.joystick = bench.publisher(WrenchStamped, "joystick")
        self.path = bench.publisher(Path, "path")
        self.demands: list[WrenchStamped] = bench.hear(WrenchStamped, "tau_desired")
        self.statuses: list[ControllerStatus] = bench.hear(ControllerStatus, "controller_status")

    def sample(self, message: Odometry) -> tuple[WrenchStamped, ControllerStatus]:
        """Send one odometry and wait for its demand and status."""
        stamp = message.header.stamp
        self.odometry.publish(message)
        self.bench.wait_until(
            lambda: self.demands and self.demands[-1].header.stamp == stamp, "a demand for this odometry"
        )
        self.bench.wait_until(lambda: self.statuses and self.statuses[-1].header.stamp == stamp, "its status")
        return self.demands[-1], self.statuses[-1]

    def answered(self, k: int) -> None:
        """Wait until the node has taken the allocator's answer to sample ``k``."""
        node = self.bench.node
        self.bench.wait_until(lambda: node._achieved[0] == START + k * STEP, "the answer taken")

    def tell(self, publisher: Any, message: Any) -> ControllerStatus:
        """Send an operator input and wait for the answer."""
        count = len(self.statuses)
        publisher.publish(message)
        return self.bench.wait_for("controller_status", count + 1)[-1]


@pytest.fixture
def ring(ros_domain_id: int) -> Iterator[Callable[..., Ring]]:
    opened: list[Any] = []

    def make(**parameters: Any) -> Ring:
        context = node_bench(ControllerNode, **parameters)
        opened.append(context)
        return Ring(context.__enter__())

    yield make
    for context in opened:
        context.__exit__(None, None, None)


def test_same_numbers_as_the_core(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    core = Controller(VESSEL, ControllerSettings(mode="setpoint"))
    achieved = None
    for k in range(30):
        if k == 5:
            answer = ship.tell(ship.setpoint, setpoint([0.3, -0.2, 0.4], START + 4 * STEP))
            assert answer.message == "accepted: set point 0.300 m, -0.200 m, 0.4000 rad"
            assert to_nanoseconds(answer.setpoint_stamp) == START + 4 * STEP
            core.set_setpoint([0.3, -0.2, 0.4])
        position = np.array([0.01 * k, -0.02 * k, 3.1 + 0.01 * k])
        velocity = np.array([0.05, -0.1, 0.01 * math.sin(k)])
        demand, status = ship.sample(odometry(k, position, velocity))
        output = core.step(ControllerInputs(position, velocity, achieved), 0.2)
        # The heading travels as a quaternion: some roundings of 3 rad, times the gains and the differences so far.
        assert vector(demand) == pytest.approx(output.tau_desired.tolist(), abs=1e-11)
        assert demand.header.frame_id == BODY_FRAME
        assert status.mode == output.mode
        assert tuple(status.axis_mode) == output.axis_mode
        for name in ("reference_position", "reference_velocity", "error", "proportional", "integral", "derivative"):
            assert list(getattr(status, name)) == pytest.approx(getattr(output, name).tolist(), abs=1e-11), name
        # Thrusters that give half of what is asked for: anti-windup goes the same way as well.
        achieved = 0.5 * output.tau_desired
        ship.achieved.publish(wrench(START + k * STEP, achieved))
        ship.answered(k)
    assert len(ship.demands) == 30
    assert len(ship.statuses) == 31


def test_an_answer_to_another_demand_is_not_fed_back(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    ship.sample(odometry(0))
    ship.sample(odometry(1, [-0.5, 0.0, 0.0]))
    ship.achieved.publish(wrench(START, [-1e6, 0.0, 0.0]))  # answers sample 0, not sample 1
    ship.answered(0)
    _, status = ship.sample(odometry(2, [-0.5, 0.0, 0.0]))
    assert status.integral[0] == pytest.approx(2 * 3.0 * 0.5 * 0.2)


def test_synchronous_node_waits_for_the_allocator(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint", synchronous=True)
    ship.sample(odometry(0))
    ship.odometry.publish(odometry(1))
    ship.odometry.publish(odometry(2))
    ship.bench.wait_until(lambda: ship.bench.node._gate.held == 2, "both held")
    assert len(ship.demands) == 1
    ship.achieved.publish(wrench(START, [0.0, 0.0, 0.0]))
    ship.bench.wait_for("tau_desired", 2)
    assert ship.bench.node._gate.held == 1
    # An answer that cannot be used still is one: the ring does not stop.
    ship.achieved.publish(wrench(START + STEP, [math.nan, 0.0, 0.0]))
    ship.bench.wait_for("tau_desired", 3)
    assert "tau_achieved: expected finite numbers" in ship.bench.diagnostics()["message"]


def test_wind_is_fed_forward_as_in_the_core(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint", **{"wind_feedforward.enabled": True})
    wind = ship.bench.publisher(Vector3Stamped, "wind")
    winds = [(-2.0 - 0.1 * k, 0.5 * (-1) ** k) for k in range(6)]
    settings = {"mode": "setpoint", "wind_feedforward": {"enabled": True}}
    core = Controller(VESSEL, ControllerSettings.model_validate(settings))
    wind.publish(wind_at(0, *winds[0]))
    for k in range(5):
        # The wind of the next odometry is there already, and is left for it.
        wind.publish(wind_at(k + 1, *winds[k + 1]))
        ship.bench.wait_until(lambda: ship.bench.node._wind.reaches(START + (k + 1) * STEP), "the wind")  # noqa: B023
        demand, status = ship.sample(odometry(k))
        output = core.step(ControllerInputs(np.zeros(3), np.zeros(3), None, True, np.array(winds[k])), 0.2)
        assert list(status.wind_feedforward) == output.wind_feedforward.tolist()
        assert vector(demand) == output.tau_desired.tolist()


def test_synchronous_node_waits_for_the_wind_of_the_odometry(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint", synchronous=True, **{"wind_feedforward.enabled": True})
    bench, room = ship.bench, ship.bench.node._room
    ship.odometry.publish(odometry(0))
    bench.wait_until(lambda: room.holds, "the odometry held")
    assert "odometry waits for an input: wind, which nobody publishes" in bench.diagnostics()["message"]
    wind = bench.publisher(Vector3Stamped, "wind")
    wind.publish(wind_at(-1, -5.0, 0.0))
    bench.wait_until(lambda: len(bench.node._wind) == 1, "the wind before")
    assert room.holds
    wind.publish(wind_at(0, -2.0, 0.5))
    bench.wait_for("controller_status")
    expected = Controller(VESSEL, bench.node.settings).step(
        ControllerInputs(np.zeros(3), np.zeros(3), None, True, np.array([-2.0, 0.5])), 0.2
    )
    assert list(ship.statuses[-1].wind_feedforward) == expected.wind_feedforward.tolist()
    ship.achieved.publish(wrench(START, expected.tau_desired))
    ship.answered(0)
    # A wind that is refused is an answer too: the ring goes on, on the estimate so far.
    ship.odometry.publish(odometry(1))
    bench.wait_until(lambda: room.holds, "the next odometry held")
    wind.publish(wind_at(1, math.nan, 0.5))
    bench.wait_for("controller_status", 2)
    assert list(ship.statuses[-1].wind_feedforward) == expected.wind_feedforward.tolist()
    assert "wind: expected finite numbers" in bench.diagnostics()["last_refusal"]
    ship.achieved.publish(wrench(START + STEP, ship.statuses[-1].wind_feedforward))
    ship.answered(1)
    # Switched off, it waits no longer.
    ship.odometry.publish(odometry(2))
    bench.wait_until(lambda: room.holds, "the third odometry held")
    assert bench.set_parameters(wind_feedforward__enabled=False).successful
    bench.wait_for("tau_desired", 3)


def test_wind_is_heard_from_when_it_is_needed(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    names = [s.topic_name for s in ship.bench.node.subscriptions]
    assert not any(name.endswith("/wind") for name in names)
    assert ship.bench.set_parameters(wind_feedforward__enabled=True).successful
    wind = ship.bench.publisher(Vector3Stamped, "wind")
    wind.publish(wind_at(0, -2.0, 0.0, frame=MAP_FRAME))
    ship.bench.wait_until(lambda: len(ship.bench.node._wind) == 1, "the wind")
    assert "wind: expected frame 'base_link_frd', found 'map_ned'" in ship.bench.diagnostics()["last_refusal"]
    for k in range(12):
        _, status = ship.sample(odometry(k))
    assert status.status == "wind_stale"


def test_feedforward_without_wind_forces_is_refused(ring: Callable[..., Ring], tmp_path: PathOnDisk) -> None:
    content = VESSEL.model_dump(mode="json", exclude={"wind_forces"}) | {"name": "bare"}
    path_ = tmp_path / "bare.yaml"
    path_.write_text(yaml.safe_dump(content), encoding="utf-8")
    ship = ring(vessel=str(path_))
    result = ship.bench.set_parameters(wind_feedforward__enabled=True)
    assert not result.successful
    assert "wind_feedforward.enabled: expected false, because vessel 'bare' has no section wind_forces" in result.reason


def test_operator_is_answered_before_any_odometry(ring: Callable[..., Ring]) -> None:
    ship = ring()
    assert ship.tell(ship.setpoint, setpoint([1.0, 2.0, 0.3])).message.endswith("waits for an automatic axis")
    assert ship.tell(ship.joystick, wrench(0, [1.0, 2.0, 3.0])).message == "accepted: joystick"
    answer = ship.tell(ship.path, path([1.0, 30.0], [[0, 0, 0], [1, 0, 0]]))
    assert answer.message == "accepted: path of 2 poses; waits for odometry"
    count = len(ship.statuses)
    assert ship.bench.set_parameters(mode="tracking").successful
    answer = ship.bench.wait_for("controller_status", count + 1)[-1]
    assert answer.mode == "tracking"
    assert list(answer.axis_mode) == ["automatic"] * 3
    assert answer.message.startswith("accepted: mode tracking")
    assert not ship.demands
    _, status = ship.sample(odometry(0))
    assert status.status == "nominal"
    for k in range(1, 161):
        _, status = ship.sample(odometry(k))
    assert status.reference_position[0] == pytest.approx(1.0, abs=1e-9)


def test_path_times_are_those_of_odometry(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="tracking")
    for k in range(3):
        ship.sample(odometry(k))
    answer = ship.tell(ship.path, path([1.0, 11.0, 21.0, 31.0], [[0.05 * t, 0, 0] for t in (0.0, 10.0, 20.0, 30.0)]))
    assert answer.message == "accepted: path of 4 poses from 1.0 s to 31.0 s"
    for k in range(3, 81):  # to 16 s, in the middle of the leg at constant speed
        _, status = ship.sample(odometry(k))
    assert status.reference_position[0] == pytest.approx(0.75, abs=1e-9)
    assert status.reference_velocity[0] == pytest.approx(0.05, abs=1e-9)


def test_joystick_goes_stale_by_its_stamp(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="joystick", joystick_timeout=1.0, transfer_time=1.0)
    ship.sample(odometry(0))
    answer = ship.tell(ship.joystick, wrench(START + STEP, [4.0, -3.0, 0.5]))
    assert to_nanoseconds(answer.joystick_stamp) == START + STEP
    demand, status = ship.sample(odometry(1))
    assert vector(demand) == [4.0, -3.0, 0.5]
    assert list(status.joystick) == [4.0, -3.0, 0.5]
    _, status = ship.sample(odometry(5))
    assert status.status == "nominal"
    demand, status = ship.sample(odometry(8))  # 1.4 s old: 0.4 s into the fade
    assert status.status == "joystick_stale"
    assert vector(demand) == pytest.approx([2.4, -1.8, 0.3], abs=1e-6)
    demand, _ = ship.sample(odometry(17))
    assert not any(vector(demand))
    found = ship.bench.diagnostics()
    assert (found["status"], found["level"]) == ("joystick_stale", 1)
    assert found["alarm.CONTROLLER-JOYSTICK-STALE"] in found["message"]


def test_invalid_observer_is_told_by_its_covariance(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    ship.sample(odometry(0))
    for k in range(1, 11):
        _, before = ship.sample(odometry(k, [-0.2, 0.0, 0.0]))
    unknown = [math.nan] * 3
    for k in range(11, 40):
        demand, status = ship.sample(odometry(k, unknown, unknown, valid=False))
        assert status.status == "observer_invalid"
    assert vector(demand) == pytest.approx(list(before.integral), abs=1e-12)
    found = ship.bench.diagnostics()
    assert found["level"] == 2
    assert "alarm.CONTROLLER-OBSERVER-INVALID" in found
    demand, status = ship.sample(odometry(40, [-0.2, 0.0, 0.0]))
    assert status.status == "nominal"


def bad_quaternion() -> Odometry:
    message = odometry(3)
    message.pose.pose.orientation.w = 2.0
    return message


def wrong_frames(frame: str, child: str) -> Odometry:
    message = odometry(3)
    message.header.frame_id, message.child_frame_id = frame, child
    return message


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (odometry(3, [math.nan, 0.0, 0.0]), "odometry: expected finite numbers, found [nan, 0.0]"),
        (odometry(3, velocity=[0.0, math.inf, 0.0]), "odometry twist: expected finite numbers, found [0.0, inf, 0.0]"),
        (bad_quaternion(), "odometry orientation: expected a unit quaternion, found (0.0, 0.0, 0.0, 2.0)"),
        (wrong_frames("map", BODY_FRAME), "odometry: expected frame 'map_ned', found 'map'"),
        (
            wrong_frames(MAP_FRAME, "base_link"),
            "odometry child_frame_id: expected frame 'base_link_frd', found 'base_link'",
        ),
        (odometry(2), "odometry: expected a time stamp after 1700000000.400 s, found 1700000000.400 s"),
        (odometry(1), "odometry: expected a time stamp after 1700000000.400 s, found 1700000000.200 s"),
    ],
)
def test_bad_odometry_is_refused_and_nothing_is_lost(ring: Callable[..., Ring], bad: Odometry, reason: str) -> None:
    ship = ring(mode="setpoint")
    core = Controller(VESSEL, ControllerSettings(mode="setpoint"))
    at = np.array([0.1, 0.2, 0.3])
    for k in range(3):
        ship.sample(odometry(k, at))
        core.step(ControllerInputs(at, np.zeros(3), None), 0.2)
    ship.odometry.publish(bad)
    moved = at + np.array([0.1, 0.0, 0.1])
    demand, _ = ship.sample(odometry(3, moved))
    expected = core.step(ControllerInputs(moved, np.zeros(3), None), 0.2).tau_desired
    assert vector(demand) == pytest.approx(expected.tolist(), abs=1e-11)
    assert len(ship.demands) == 4
    assert ship.bench.diagnostics()["message"] == f"refused: {reason}"


@pytest.mark.parametrize(
    ("topic", "bad", "reason"),
    [
        ("setpoint", setpoint([math.nan, 0.0, 0.0]), "set point: expected finite numbers, found [nan, 0.0]"),
        ("setpoint", setpoint([0, 0, 0], frame="odom"), "set point: expected frame 'map_ned', found 'odom'"),
        (
            "setpoint",
            setpoint([0, 0, 0], stamp=START),
            "set point: expected a time stamp of at least 1700000000.200 s, found 1700000000.000 s",
        ),
        ("joystick", wrench(0, [0.0, 0.0, math.inf]), "joystick: expected finite numbers, found [0.0, 0.0, inf]"),
        (
            "joystick",
            wrench(0, [0, 0, 0], frame=MAP_FRAME),
            "joystick: expected frame 'base_link_frd', found 'map_ned'",
        ),
        (
            "joystick",
            wrench(START + 1000 * STEP, [0, 0, 0]),
            "joystick time: expected at most 2.000 s after the last estimate, found 199.600 s",
        ),
        ("path", path([], []), "path: expected at least one pose, found none"),
        ("path", path([5.0, 4.0], [[0, 0, 0]] * 2), "path times: expected them to increase"),
        ("path", path([5.0, 6.0], [[0, 0, 0], [0, math.nan, 0]]), "path pose 1: expected finite numbers"),
        ("path", path([5.0], [[0, 0, 0]], frame=BODY_FRAME), "path: expected frame 'map_ned', found 'base_link_frd'"),
    ],
)
def test_bad_operator_input_is_answered_and_the_last_good_one_kept(
    ring: Callable[..., Ring], topic: str, bad: Any, reason: str
) -> None:
    ship = ring(mode="semi_automatic")
    for k in range(3):
        ship.sample(odometry(k))
    good = [
        ship.tell(ship.setpoint, setpoint([0.0, 0.0, 0.2], stamp=START + STEP)),
        ship.tell(ship.joystick, wrench(START + 2 * STEP, [1.0, 2.0, 0.0])),
    ]
    answer = ship.tell(getattr(ship, topic), bad)
    assert answer.message.startswith("refused: ")
    assert reason in answer.message
    assert answer.setpoint_stamp == good[-1].setpoint_stamp
    assert answer.joystick_stamp == good[-1].joystick_stamp
    for k in range(3, 6):
        demand, status = ship.sample(odometry(k))
    assert vector(demand)[:2] == [1.0, 2.0]
    assert status.reference_position[2] > 0.0
    assert reason in ship.bench.diagnostics()["message"]


def test_bad_parameters_are_refused_live_and_nothing_changes(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    for change, field in (
        ({"mode": "autopilot"}, "mode"),
        ({"transfer_time": -1.0}, "transfer_time"),
        ({"proportional_scale": [1.0, 11.0, 1.0]}, "proportional_scale"),
        ({"tau_max": [1.0, 1.0]}, "tau_max"),
        ({"mode": "standby", "axis_yaw": "manual"}, "axis_yaw"),
    ):
        result = ship.bench.set_parameters(**change)
        assert not result.successful
        assert field in result.reason
    _, status = ship.sample(odometry(0))
    assert status.mode == "setpoint"


def test_bad_parameter_at_start_is_refused(ros_domain_id: int) -> None:
    with pytest.raises(InputError, match=r"mode.*autopilot"), node_bench(ControllerNode, mode="autopilot"):
        pass


def test_mode_change_over_the_graph_is_bumpless(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="joystick", joystick_timeout=0.0)
    ship.tell(ship.joystick, wrench(0, [5.0, -4.0, 1.0]))
    ship.sample(odometry(0))
    before, _ = ship.sample(odometry(1, velocity=[0.05, 0.02, 0.01]))
    assert ship.bench.set_parameters(mode="setpoint").successful
    after, status = ship.sample(odometry(2, velocity=[0.05, 0.02, 0.01]))
    assert status.mode == "setpoint"
    assert vector(after) == pytest.approx(vector(before), abs=1e-12)


def test_new_activation_begins_anew(ring: Callable[..., Ring]) -> None:
    ship = ring(mode="setpoint")
    for k in range(10):
        ship.sample(odometry(k, [0.1 * k, 0.0, 0.0]))
    node = ship.bench.node
    node.trigger_deactivate()
    ship.odometry.publish(odometry(10))
    ship.bench.wait_until(lambda: node.ignored == 1, "an ignored odometry")
    node.trigger_activate()
    demand, status = ship.sample(odometry(0, [3.0, 2.0, 1.0]))  # a simulation begun anew: time jumped back
    assert not any(vector(demand))
    assert not any(status.integral)
    assert len(ship.demands) == 11
