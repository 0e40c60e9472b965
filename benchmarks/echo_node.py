"""The peer of the hop: a plain rclpy node that answers every wrench with the same wrench.

Plain means: rclpy.node.Node with parameter services as ever, rclpy's SingleThreadedExecutor, no code of ours but the
quality of service, which must be the same.
"""

from __future__ import annotations

import sys
from typing import Any

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from dp_node import RING, RING_PUBLISHER

REQUEST = "echo_request"
ANSWER = "echo_answer"


class EchoNode(Node):
    """Node ``echo``."""

    def __init__(self) -> None:
        super().__init__("echo")
        self._publisher = self.create_publisher(WrenchStamped, ANSWER, RING_PUBLISHER)
        self.create_subscription(WrenchStamped, REQUEST, self._on_request, RING)

    def _on_request(self, message: Any) -> None:
        self._publisher.publish(message)


def main() -> None:
    """Answer until SIGINT or SIGTERM."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(EchoNode())
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        sys.exit(0)


if __name__ == "__main__":
    main()
