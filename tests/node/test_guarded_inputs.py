"""Inputs of real nodes: a second publisher, and a source that begins anew."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from dp_msgs.msg import ActuatorSetpoint, ThrusterCommand, ThrusterFeedback
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry

from dp_node import RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_node.stamps import BELIEVED
from dp_observer.node import ObserverNode
from marine_model import load_vessel
from marine_model.frames import BODY_FRAME, MAP_FRAME
from support.node_bench import NodeBench, node_bench
from thruster_drivers.node import DriversNode

pytestmark = pytest.mark.usefixtures("ros_domain_id")

NAMES = load_vessel("cybership3").thruster_names
SAMPLE = 100_000_000  # ns
START = 1_000 * SAMPLE


def command(number: int, thrust: float) -> ThrusterCommand:
    message = ThrusterCommand(name=list(NAMES), thrust=array("d", [thrust] * 4), azimuth=array("d", [0.0] * 4))
    message.header.stamp = from_nanoseconds(START + number * SAMPLE)
    return message


class Peers:
    """Drivers that hear thruster_command of ``allocator``, and of ``intruder`` once it is there."""

    def __init__(self, bench: NodeBench) -> None:
        self.bench = bench
        self.setpoints = bench.hear(ActuatorSetpoint, "actuator_setpoint")
        self.nodes: list[Any] = []
        self.sent = 0

    def join(self, name: str) -> Any:
        node = rclpy.create_node(name)
        self.nodes.append(node)
        publisher = node.create_publisher(ThrusterCommand, "thruster_command", RING_PUBLISHER)
        subscription = next(s for s in self.bench.node.subscriptions if s.topic_name == "/thruster_command")
        matched = len(self.nodes)
        self.bench.wait_until(lambda: subscription.get_publisher_count() >= matched, f"{name} to be matched")
        return publisher

    def send(self, publisher: Any) -> None:
        self.sent += 1
        publisher.publish(command(self.sent, 0.1))

    def heard(self) -> int:
        return int(self.bench.diagnostics()["commands"])


@pytest.fixture(params=[True, False])
def peers(ros_domain_id: int, request: pytest.FixtureRequest) -> Iterator[Peers]:
    with node_bench(DriversNode, exclusive_inputs=request.param) as bench:
        made = Peers(bench)
        yield made
        for node in made.nodes:
            node.destroy_node()


def test_a_second_publisher_of_commands_is_named_and_refused_unless_told_otherwise(peers: Peers) -> None:
    bench, exclusive = peers.bench, peers.bench.node.get_parameter("exclusive_inputs").value
    allocator = peers.join("allocator")
    for _ in range(3):
        peers.send(allocator)
    bench.wait_until(lambda: peers.heard() == 3)
    assert "alarm.NODE-SECOND-PUBLISHER" not in bench.diagnostics()
    intruder = peers.join("intruder")
    # Reliable and in order: once the last of the allocator's is heard, all of those before have been judged.
    for _ in range(10):
        peers.send(intruder)
        peers.send(allocator)
    bench.wait_until(lambda: peers.heard() == (13 if exclusive else 23))
    said = bench.diagnostics()
    assert said["refused_of_others"] == "10"
    assert said["level"] == 2
    told = said["alarm.NODE-SECOND-PUBLISHER"]
    assert "thruster_command, from allocator, intruder" in told
    if not exclusive:
        assert "refused" not in told
        return
    assert "heard is allocator, of others 10 were refused" in told
    # The established one leaves: the newcomer, alone, is heard.
    peers.nodes.pop(0).destroy_node()
    subscription = next(s for s in bench.node.subscriptions if s.topic_name == "/thruster_command")
    bench.wait_until(lambda: subscription.get_publisher_count() == 1, "the allocator to leave")
    peers.send(intruder)
    bench.wait_until(lambda: peers.heard() == 14)
    assert "alarm.NODE-SECOND-PUBLISHER" not in bench.diagnostics()


def test_drivers_begin_anew_with_the_source_of_their_feedback(ros_domain_id: int) -> None:
    with node_bench(DriversNode) as bench:
        setpoints = bench.hear(ActuatorSetpoint, "actuator_setpoint")
        feedback = bench.publisher(ThrusterFeedback, "thruster_feedback")
        commands = bench.publisher(ThrusterCommand, "thruster_command")

        def send(nanoseconds: int) -> None:
            zero = array("d", [0.0] * 4)
            message = ThrusterFeedback(
                name=list(NAMES), shaft_speed=zero, torque=zero, power=zero, azimuth=zero, azimuth_rate=zero
            )
            message.header.stamp = from_nanoseconds(nanoseconds)
            feedback.publish(message)

        send(START)
        bench.wait_for("actuator_setpoint", 1)
        commands.publish(command(0, 1.0))
        bench.wait_for("actuator_setpoint", 2)
        # One stamp behind is refused; the feedback that follows is answered as ever.
        send(0)
        send(START + SAMPLE // 10)
        bench.wait_for("actuator_setpoint", 3)
        assert to_nanoseconds(setpoints[-1].header.stamp) == START + SAMPLE // 10
        assert any(setpoints[-1].torque)
        for k in range(BELIEVED):
            send(k * SAMPLE // 10)
        bench.wait_for("actuator_setpoint", 4)
        assert to_nanoseconds(setpoints[-1].header.stamp) == (BELIEVED - 1) * SAMPLE // 10
        assert not any(setpoints[-1].torque), "no command is known any more"
        said = bench.diagnostics()
        assert (
            "thruster_feedback: its source began anew: time stamps jumped from 100.010 s to 0.020 s"
            in said["alarm.NODE-SOURCE-RESTARTED"]
        )
        assert said["refused_inputs"] == str(1 + BELIEVED - 1)
        assert said["status"] == "no_command"


def test_the_observer_begins_anew_with_the_source_of_its_poses(ros_domain_id: int) -> None:
    with node_bench(ObserverNode, synchronous=False) as bench:
        estimates = bench.hear(Odometry, "odometry")
        poses = bench.publisher(PoseWithCovarianceStamped, "pose")

        def send(nanoseconds: int, north: float) -> None:
            message = PoseWithCovarianceStamped()
            message.header.stamp = from_nanoseconds(nanoseconds)
            message.header.frame_id = MAP_FRAME
            message.pose.pose.position.x = north
            message.pose.pose.orientation.w = 1.0
            poses.publish(message)

        send(START, 5.0)
        bench.wait_until(lambda: any(to_nanoseconds(e.header.stamp) == START for e in estimates))
        for k in range(BELIEVED):
            send(k * SAMPLE, -7.0)
        last = (BELIEVED - 1) * SAMPLE
        bench.wait_until(lambda: any(to_nanoseconds(e.header.stamp) == last for e in estimates))
        (first,) = [e for e in estimates if to_nanoseconds(e.header.stamp) == last]
        # A first fix is believed at once: nothing is left of the estimate from before.
        assert first.pose.pose.position.x == pytest.approx(-7.0, abs=1e-9)
        assert first.child_frame_id == BODY_FRAME
