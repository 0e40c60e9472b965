"""The allocator's node with submerged vehicles and other methods than the quadratic program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import AllocationStatus, ThrusterCommand
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.settings import with_parameters
from support.node_bench import NodeBench, node_bench
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings
from thrust_allocator.node import AllocatorNode

pytestmark = pytest.mark.usefixtures("ros_domain_id")

STEP = 200_000_000  # ns
START = 7_000_000_000
PARTS = ("force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z")


class Bench:
    """The node on its bench, demands and answers in six degrees of freedom."""

    def __init__(self, bench: NodeBench) -> None:
        self.bench = bench
        self.commands = bench.hear(ThrusterCommand, "thruster_command")
        self.achieved = bench.hear(WrenchStamped, "tau_achieved")
        self.statuses = bench.hear(AllocationStatus, "allocation_status")
        self.demands = bench.publisher(WrenchStamped, "tau_desired")

    def send(self, stamp: int, six: tuple[float, ...]) -> None:
        message = WrenchStamped()
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = "base_link_frd"
        for part, value in zip(PARTS, six, strict=True):
            kind, axis = part.split(".")
            setattr(getattr(message.wrench, kind), axis, value)
        self.demands.publish(message)

    def ask(self, stamp: int, six: tuple[float, ...]) -> tuple[Any, Any, Any]:
        count = len(self.statuses) + 1
        self.send(stamp, six)
        return self.answer(count)

    def answer(self, count: int) -> tuple[Any, Any, Any]:
        self.bench.wait_until(
            lambda: min(len(self.commands), len(self.achieved), len(self.statuses)) >= count, "three answers"
        )
        return self.commands[-1], self.achieved[-1], self.statuses[-1]


@pytest.fixture
def start() -> Iterator[Any]:
    with ExitStack() as stack:
        yield lambda **parameters: Bench(stack.enter_context(node_bench(AllocatorNode, **parameters)))


def assert_tells(answer: tuple[Any, Any, Any], result: AllocationResult) -> None:
    """The core's numbers, all of them."""
    command, achieved, status = answer
    np.testing.assert_array_equal(command.thrust, result.thrust)
    np.testing.assert_array_equal(command.azimuth, result.azimuth)
    wrench = achieved.wrench
    found = [wrench.force.x, wrench.force.y, wrench.force.z, wrench.torque.x, wrench.torque.y, wrench.torque.z]
    np.testing.assert_array_equal(found, result.wrench)
    np.testing.assert_array_equal(status.slack, result.slack)
    assert (status.method, status.detail) == (result.method, result.detail)
    np.testing.assert_array_equal(status.feasible_load, result.feasible_load)
    if result.method == "qp":
        assert len(status.tau_feasible) == len(status.tau_qp) == 0
    else:
        np.testing.assert_array_equal(status.tau_feasible, result.tau_feasible)
        np.testing.assert_array_equal(status.tau_qp, result.tau_qp)
    assert status.margin == result.margin.fixed


def test_methods_are_switched_while_it_runs(start: Any) -> None:
    """Demand and answer along all axes of the vehicle; refused where a method does not fit, with the reason."""
    vessel = load_vessel("ukwial")
    settings = AllocatorSettings.for_vessel(vessel)
    bench, expected = start(vessel="ukwial"), Allocator(vessel, settings)
    six = (700.0, -120.0, 480.0, 5.0, 6.0, 30.0)  # roll and pitch are not the vehicle's to give: not read
    tau, stamp = np.array(six)[vessel.axis_indices], START
    assert_tells(bench.ask(stamp, six), expected.step(tau, 0.2))
    for changes in (
        {"method": "pseudo_inverse"},
        {"feasible": "proportional"},
        {"feasible": "priority", "priority.axis": "surge", "priority.weights": [1.0, 1.0, 1.0, 3.0]},
        {"compare_qp": False},
        {"method": "qp"},
    ):
        settings = with_parameters(settings, changes)
        asked = {name.replace(".", "__"): value for name, value in changes.items()}
        assert bench.bench.set_parameters(**asked).successful
        expected.apply(settings)
        for _ in range(2):
            answer = bench.ask(stamp := stamp + STEP, six)
            result = expected.step(tau, 0.2)
            if changes == {"compare_qp": False}:
                assert len(answer[2].tau_qp) == 0
                np.testing.assert_array_equal(answer[0].thrust, result.thrust)
            else:
                assert_tells(answer, result)
    refused = bench.bench.set_parameters(method="garus_azimuth")
    assert not refused.successful
    assert refused.reason.startswith("garus_azimuth: expected four azimuth thrusters")
    refused = bench.bench.set_parameters(portions__surge=0.7)
    assert not refused.successful
    assert refused.reason == "portions.surge + portions.yaw: expected 1, found 1.2"
    health = bench.bench.diagnostics()
    assert health["method"] == "qp"
    assert not any("FELL-BACK" in key for key in health)


def test_what_a_method_reduces_is_in_the_diagnostics(start: Any) -> None:
    bench = start(vessel="ukwial_azimuth", method="garus_azimuth")
    status = bench.ask(START, (0.0, 0.0, 0.0, 0.0, 0.0, 80.0))[2]
    assert status.feasible_load == pytest.approx(1.6)
    health = bench.bench.diagnostics()
    assert health["method"] == "garus_azimuth"
    assert health["reduced"].startswith("yaw of 80 N m is beyond the reserved 50 N m")


def test_deactivated_a_vehicle_says_what_is_left_along_all_axes(start: Any) -> None:
    vessel = load_vessel("mmt300")
    bench = start(vessel="mmt300", method="portioned", portions__speed_limited=False)
    stamp = START
    for _ in range(4):
        command, _, _ = bench.ask(stamp := stamp + STEP, (60.0, 0.0, 20.0, 0.0, 5.0, 5.0))
    bench.bench.node.trigger_deactivate()
    command, achieved, status = bench.ask(stamp := stamp + STEP, (60.0, 0.0, 20.0, 0.0, 5.0, 5.0))
    assert status.status == "deactivated"
    left = np.array(command.thrust) @ vessel.columns6[:, :, 0]
    assert np.abs(left).max() > 1.0
    wrench = achieved.wrench
    found = [wrench.force.x, wrench.force.y, wrench.force.z, wrench.torque.x, wrench.torque.y, wrench.torque.z]
    np.testing.assert_allclose(found, left, atol=1e-9)


def odometry(stamp: int, speed: float, valid: bool = True) -> Odometry:
    message = Odometry()
    message.header.stamp = from_nanoseconds(stamp)
    message.header.frame_id = "map_ned"
    message.child_frame_id = "base_link_frd"
    message.twist.twist.linear.x = speed
    if not valid:
        message.pose.covariance[0] = -1.0
    return message


def test_lockstep_waits_for_the_speed_of_the_demand_s_own_sample(start: Any) -> None:
    """From the first demand on: the estimate of a sample comes before its demand, though it may be heard after it."""
    vessel = load_vessel("mmt300")
    bench = start(vessel="mmt300", method="portioned", synchronous=True)
    expected = Allocator(vessel, AllocatorSettings.for_vessel(vessel, method="portioned"))
    node, six = bench.bench.node, (500.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    tau, stamp = np.array(six)[vessel.axis_indices], START
    heard = bench.bench.publisher(Odometry, "odometry")
    for count, (speed, valid, counts) in enumerate(
        [(1.0, True, 1.0), (2.0, True, 2.0), (0.5, False, 2.0), (float("nan"), True, 2.0), (0.0, True, 0.0)], start=1
    ):
        bench.send(stamp, six)
        bench.bench.wait_until(lambda: node._room.holds, "the demand to be held")
        assert len(bench.statuses) == count - 1
        assert bench.bench.diagnostics()["message"].startswith("tau_desired waits for an input: odometry")
        heard.publish(odometry(stamp, speed, valid))
        answer = bench.answer(count)
        assert to_nanoseconds(answer[2].header.stamp) == stamp
        expected.measure_speed(counts)
        assert_tells(answer, expected.step(tau, 0.2))
        stamp += STEP
    # Here before its demand: no wait.
    heard.publish(odometry(stamp, 1.5))
    bench.bench.wait_until(lambda: len(node._speed) == 6, "the estimate")
    expected.measure_speed(1.5)
    assert_tells(bench.ask(stamp, six), expected.step(tau, 0.2))
