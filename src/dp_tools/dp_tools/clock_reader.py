"""Newest simulated time, taken only when asked for."""

from __future__ import annotations

import os

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from dp_node import RingExecutor, to_nanoseconds


class ClockReader:
    """Reads the clock of a graph on demand.

    It has a node and an executor of its own, depth 1 and best effort: a clock that ticks a thousand times a second is
    not worth a callback a tick.

    Parameters
    ----------
    beside
        A node in the graph's namespace: every simulator has a clock of its own, /clock where there is no namespace.
    """

    def __init__(self, beside: Node) -> None:
        self._time = 0.0
        self._node = rclpy.create_node(
            # Hidden: nobody's to talk to.
            f"_dp_clock_reader_{os.getpid()}",
            context=beside.context,
            namespace=beside.get_namespace(),
            start_parameter_services=False,
        )
        quality = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._node.create_subscription(Clock, "clock", self._note, quality)
        self._executor = RingExecutor(context=beside.context)
        self._executor.add_node(self._node)

    def _note(self, message: Clock) -> None:
        self._time = to_nanoseconds(message.clock) * 1e-9

    def time(self) -> float:
        """Return the newest simulated time, s; 0 before the first tick."""
        self._executor.spin_once(timeout_sec=0.0)
        return self._time

    def close(self) -> None:
        """Give the node back."""
        self._executor.shutdown()
        self._node.destroy_node()
