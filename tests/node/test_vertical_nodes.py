"""Observer and controller of submerged vehicles over real DDS: depth, roll and pitch in every message."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import ControllerStatus, ObserverState
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry

from dp_controller import Controller, ControllerInputs, ControllerSettings
from dp_controller.node import ControllerNode
from dp_controller.vertical import VerticalInputs
from dp_node import from_nanoseconds
from dp_observer import Observer, ObserverInputs, ObserverSettings
from dp_observer.node import ObserverNode
from marine_model import load_vessel
from marine_model.frames import (
    BODY_FRAME,
    MAP_FRAME,
    attitude_to_quaternion,
    quaternion_to_attitude,
    quaternion_to_heading,
)
from marine_model.guards import FloatArray
from support.node_bench import NodeBench, node_bench

pytestmark = pytest.mark.usefixtures("ros_domain_id")

VESSEL = load_vessel("mmt300")
STEP = 200_000_000  # ns
START = 7_000_000_000
PLANE, BELOW = [0, 1, 5], [2, 3, 4]


def pose_into(pose: Any, place: FloatArray) -> None:
    """Write north, east, depth, roll, pitch, heading."""
    pose.position.x, pose.position.y, pose.position.z = place[:3].tolist()
    q = pose.orientation
    q.x, q.y, q.z, q.w = attitude_to_quaternion(*place[3:].tolist())


def pose_of(pose: Any) -> FloatArray:
    q = pose.orientation
    attitude = quaternion_to_attitude(q.x, q.y, q.z, q.w)
    return np.array([pose.position.x, pose.position.y, pose.position.z, *attitude])


def sent(place: FloatArray) -> FloatArray:
    """Return a place as it comes out of a message."""
    message = PoseStamped()
    pose_into(message.pose, place)
    return pose_of(message.pose)


def wrench(stamp: int, tau: FloatArray) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id, message.header.stamp = BODY_FRAME, from_nanoseconds(stamp)
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = tau.tolist()
    return message


def wrench_of(message: WrenchStamped) -> FloatArray:
    force, torque = message.wrench.force, message.wrench.torque
    return np.array([force.x, force.y, force.z, torque.x, torque.y, torque.z])


def refused(bench: NodeBench, reason: str) -> None:
    bench.wait_until(lambda: reason in str(bench.node._last_refusal), lambda: str(bench.node._last_refusal))


def test_observer_takes_and_gives_all_six() -> None:
    with node_bench(ObserverNode, vessel="mmt300", synchronous=True) as bench:
        pose = bench.publisher(PoseWithCovarianceStamped, "pose")
        force = bench.publisher(WrenchStamped, "tau_achieved")
        odometry: list[Odometry] = bench.hear(Odometry, "odometry")
        state: list[ObserverState] = bench.hear(ObserverState, "observer_state")
        core = Observer(VESSEL, ObserverSettings())
        for k in range(12):
            tau = np.array([40.0, 0.0, -6.0, 0.5, 3.0, 2.0]) * (k > 0)
            if k == 5:  # beyond belief: neither kept nor answered
                force.publish(wrench(START + k * STEP - 1, np.array([0.0, 0.0, 1e13, 0.0, 0.0, 0.0])))
                refused(bench, "tau of heave, roll and pitch: expected numbers within")
            place = np.array([0.01 * k, -0.02, 20.0 + 0.02 * k, 0.01, -0.1 + 0.002 * k, 1.0])
            message = PoseWithCovarianceStamped()
            message.header.frame_id, message.header.stamp = MAP_FRAME, from_nanoseconds(START + k * STEP)
            pose_into(message.pose.pose, place)
            if k == 8:
                message.pose.pose.position.z = float("inf")
            if k:
                force.publish(wrench(START + (k - 1) * STEP, tau))
            pose.publish(message)
            bench.wait_for("odometry", k + 1)
            bench.wait_for("observer_state", k + 1)
            found = pose_of(message.pose.pose)
            fix = None if k == 8 else found
            expected = core.step(
                ObserverInputs(
                    None if fix is None else fix[PLANE],
                    tau[PLANE],
                    None if fix is None else fix[BELOW],
                    tau[BELOW] if k else None,
                ),
                STEP * 1e-9,
            )
            below = expected.vertical
            assert below is not None
            out = odometry[-1]
            whole = np.array([*expected.position[:2], *below.position, expected.position[2]])
            # A quaternion and back, to rounding.
            np.testing.assert_allclose(pose_of(out.pose.pose), whole, atol=1e-14)
            linear, angular = out.twist.twist.linear, out.twist.twist.angular
            assert [linear.z, angular.x, angular.y] == below.velocity.tolist()
            assert [linear.x, linear.y, angular.z] == expected.velocity.tolist()
            assert state[-1].status == expected.status
            assert list(state[-1].vertical_bias) == below.bias.tolist()
            assert list(state[-1].vertical_innovation) == below.innovation.tolist()
        assert expected.status == "nominal"
        refused(bench, "pose: depth, roll and pitch: expected finite numbers")


def test_controller_demands_what_its_core_says() -> None:
    with node_bench(ControllerNode, vessel="mmt300") as bench:
        odometry = bench.publisher(Odometry, "odometry")
        achieved = bench.publisher(WrenchStamped, "tau_achieved")
        setpoint = bench.publisher(PoseStamped, "setpoint")
        joystick = bench.publisher(WrenchStamped, "joystick")
        demands: list[WrenchStamped] = bench.hear(WrenchStamped, "tau_desired")
        statuses: list[ControllerStatus] = bench.hear(ControllerStatus, "controller_status")

        def answer(act: Any) -> ControllerStatus:
            before = len(statuses)
            act()
            bench.wait_for("controller_status", before + 1)
            return statuses[-1]

        # Surge by hand, the rest as the vehicle's defaults are: heading, depth and pitch automatic.
        values = {"mode": "semi_automatic", "axis_surge": "joystick", "joystick_timeout": 0.0}
        result = bench.set_parameters(vertical__axis_roll="automatic")
        assert not result.successful
        assert "vertical.axis_roll: expected off, because vessel 'mmt300' controls surge, heave" in result.reason
        status = answer(lambda: bench.set_parameters(**values))
        assert list(status.axis_mode) == ["joystick", "off", "automatic"]
        assert list(status.vertical_axis_mode) == ["automatic", "off", "automatic"]
        assert list(status.vertical_error) == [0.0, 0.0, 0.0]  # nothing is known yet
        core = Controller(VESSEL, ControllerSettings.for_vessel(VESSEL).model_copy(update=values))

        tau = np.zeros(6)
        goal = sent(np.array([0.0, 0.0, 21.0, 0.0, 0.1, 1.2]))
        for k in range(8):
            if k == 2:
                message = PoseStamped()
                message.header.frame_id = MAP_FRAME
                pose_into(message.pose, goal)
                assert "depth 21.000 m" in answer(lambda sending=message: setpoint.publish(sending)).message
                core.set_setpoint(goal)
                push = np.array([60.0, 5.0, 5.0, 5.0, 5.0, 5.0])
                by_hand = wrench(0, push)
                assert answer(lambda sending=by_hand: joystick.publish(sending)).message == "accepted: joystick"
                core.set_joystick(push)
            place = np.array([0.1 * k, 0.0, 20.0 + 0.02 * k, 0.02, -0.01 * k, 1.0])
            velocity = np.array([0.5, 0.0, 0.1, 0.02, -0.05, 0.0])
            message = Odometry(child_frame_id=BODY_FRAME)
            message.header.frame_id, message.header.stamp = MAP_FRAME, from_nanoseconds(START + k * STEP)
            pose_into(message.pose.pose, place)
            twist = message.twist.twist
            twist.linear.x, twist.linear.y, twist.linear.z = velocity[:3].tolist()
            twist.angular.x, twist.angular.y, twist.angular.z = velocity[3:].tolist()
            if k:
                achieved.publish(wrench(START + (k - 1) * STEP, tau))
                bench.wait_until(lambda stamp=START + (k - 1) * STEP: bench.node._achieved[0] == stamp)
            odometry.publish(message)
            bench.wait_for("tau_desired", k + 1)
            bench.wait_until(
                lambda stamp=message.header.stamp: statuses and statuses[-1].header.stamp == stamp, "its status"
            )
            heard = pose_of(message.pose.pose)
            heading = quaternion_to_heading(*attitude_to_quaternion(*place[3:].tolist()))
            expected = core.step(
                ControllerInputs(
                    np.array([heard[0], heard[1], heading]),
                    velocity[PLANE],
                    tau[PLANE],
                    True,
                    None,
                    VerticalInputs(heard[BELOW], velocity[BELOW], tau[BELOW]),
                ),
                STEP * 1e-9,
            )
            below = expected.vertical
            assert below is not None
            out = wrench_of(demands[-1])
            np.testing.assert_array_equal(out[PLANE], expected.tau_desired)
            np.testing.assert_array_equal(out[BELOW], below.tau_desired)
            assert (out[1], out[3]) == (0.0, 0.0)  # sway and roll: not its own
            last = statuses[-1]
            for name in ("reference", "error", "proportional", "integral", "derivative", "joystick", "transfer"):
                assert list(getattr(last, f"vertical_{name}")) == getattr(below, name).tolist(), name
            # The allocator falls short, so that the integral has something to give way to.
            tau = 0.9 * out
        assert out[0] == 60.0
        assert abs(out[2]) > 1.0
        told = float(bench.diagnostics()["depth_error_m"])
        assert told == pytest.approx(last.vertical_error[0], rel=1e-5)  # six digits


def test_vessels_on_the_surface_carry_nothing_below() -> None:
    with node_bench(ControllerNode, vessel="cybership3") as bench:
        odometry = bench.publisher(Odometry, "odometry")
        demands: list[WrenchStamped] = bench.hear(WrenchStamped, "tau_desired")
        statuses: list[ControllerStatus] = bench.hear(ControllerStatus, "controller_status")
        message = Odometry(child_frame_id=BODY_FRAME)
        message.header.frame_id, message.header.stamp = MAP_FRAME, from_nanoseconds(START)
        pose_into(message.pose.pose, np.array([0.0, 0.0, 5.0, 0.1, 0.1, 0.0]))
        odometry.publish(message)
        bench.wait_for("tau_desired")
        bench.wait_for("controller_status")
        assert wrench_of(demands[-1]).tolist() == [0.0] * 6
        assert list(statuses[-1].vertical_axis_mode) == list(statuses[-1].vertical_reference) == []
        assert "depth_error_m" not in bench.diagnostics()
