"""Gives a restarted controller the operator's last set point and path again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dp_msgs.msg import ControllerStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node

from dp_node import RING, RING_PUBLISHER, from_nanoseconds, to_nanoseconds

_SEND_AGAIN = 0.5  # s; a controller that has just come may not have heard of this publisher yet
_PATIENCE = 15.0  # s
_KINDS = {"setpoint": PoseStamped, "path": Path}
# A stamp of zero means "on arrival", and could not be told from that of a controller that has no input.
_ON_ARRIVAL = 1  # ns


class OperatorMemory:
    """Hears what the operator asks of the controller, and asks it again in the same order.

    The input goes out with its own stamp, so that one that the operator gives meanwhile, which is newer, stands. It is
    sent until the controller's status shows it, or something newer.

    Parameters
    ----------
    node
        Listens and publishes.
    tell
        Told what was given again, and what was not taken.
    """

    def __init__(self, node: Node, tell: Callable[[str], None]) -> None:
        self._node = node
        self._tell = tell
        self._inputs: dict[str, Any] = {}  # in the order in which they came last
        self._sending: dict[str, Any] = {}  # publishers of what is being given again
        self._status: Any = None
        self._shown = -1
        self._next = self._deadline = 0.0
        for topic in _KINDS:
            node.create_subscription(_KINDS[topic], topic, self._hear(topic), RING)

    def _hear(self, topic: str) -> Callable[[Any], None]:
        def note(message: Any) -> None:
            if not self._sending:  # what is sent here comes back as well
                self._inputs.pop(topic, None)
                self._inputs[topic] = message

        return note

    def give_again(self, now: float) -> None:
        """Begin to send what is known, at ``now`` (s)."""
        self.stop()
        if not self._inputs:
            return
        for topic in self._inputs:
            self._sending[topic] = self._node.create_publisher(_KINDS[topic], topic, RING_PUBLISHER)
        self._status = self._node.create_subscription(ControllerStatus, "controller_status", self._note, RING)
        self._shown = -1
        self._next, self._deadline = now, now + _PATIENCE

    def _note(self, message: Any) -> None:
        self._shown = max(self._shown, to_nanoseconds(message.setpoint_stamp))

    def look(self, now: float) -> None:
        """Go on sending, if there is something to send."""
        if not self._sending:
            return
        stamps = {topic: to_nanoseconds(self._inputs[topic].header.stamp) or _ON_ARRIVAL for topic in self._sending}
        if self._shown >= max(stamps.values()):
            self._tell(f"dp_controller has the operator's last {' and '.join(self._sending)} again")
            self.stop()
        elif now >= self._deadline:
            self._tell(f"dp_controller did not take the operator's last {' and '.join(self._sending)}: give it anew")
            self.stop()
        elif now >= self._next:
            self._next = now + _SEND_AGAIN
            for topic, publisher in self._sending.items():
                message = self._inputs[topic]
                message.header.stamp = from_nanoseconds(stamps[topic])
                publisher.publish(message)

    def stop(self) -> None:
        """Give up what is under way."""
        for publisher in self._sending.values():
            self._node.destroy_publisher(publisher)
        if self._status is not None:
            self._node.destroy_subscription(self._status)
        self._sending, self._status = {}, None
