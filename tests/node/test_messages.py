"""The built messages travel over real DDS."""

import pytest
import rclpy
from dp_msgs.msg import ThrusterCommand
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from support.waiting import wait_until


@pytest.mark.usefixtures("ros_domain_id")
def test_a_command_arrives_as_it_was_sent() -> None:
    context = Context()
    rclpy.init(context=context)
    executor = SingleThreadedExecutor(context=context)
    received: list[ThrusterCommand] = []
    try:
        sender, receiver = (Node(name, context=context) for name in ("sender", "receiver"))
        executor.add_node(sender)
        executor.add_node(receiver)
        publisher = sender.create_publisher(ThrusterCommand, "thruster_command", 10)
        receiver.create_subscription(ThrusterCommand, "thruster_command", received.append, 10)
        wait_until(lambda: publisher.get_subscription_count() == 1, message="the subscription was matched")
        command = ThrusterCommand(thrust=[1.0, -2.5], azimuth=[0.0, 3.0])
        command.header.frame_id = "base_link_frd"
        publisher.publish(command)
        wait_until(lambda: received, spin=lambda s: executor.spin_once(timeout_sec=s), message="a command arrived")
        assert received == [command]
    finally:
        executor.shutdown()
        rclpy.shutdown(context=context)
