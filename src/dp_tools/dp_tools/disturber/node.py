"""The disturber as a ROS 2 node: between a position reference and who listens to it.

    ros2 run dp_tools disturber --ros-args -p input:=pose_measured -p output:=pose -p loss:=0.1

Faults are parameters, and may be changed while it runs.
"""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from dp_node import RING_LOCKSTEP, RING_PUBLISHER, RingExecutor, from_nanoseconds, to_nanoseconds
from dp_node.parameters import SettingsParameters
from dp_node.run import Stop
from dp_tools.disturber.disturber import Disturber, PoseSample
from dp_tools.disturber.settings import DisturberSettings
from marine_model.errors import DpError, InputError
from marine_model.frames import heading_to_quaternion, quaternion_to_heading

Inner = Callable[[Any], Any]
# Types that carry a pose, and where in the message it is.
KINDS: dict[str, tuple[Any, Inner]] = {
    "geometry_msgs/msg/PoseWithCovarianceStamped": (PoseWithCovarianceStamped, lambda message: message.pose.pose),
    "geometry_msgs/msg/PoseStamped": (PoseStamped, lambda message: message.pose),
    "nav_msgs/msg/Odometry": (Odometry, lambda message: message.pose.pose),
}


class DisturberNode(Node):
    """Relays one topic and spoils it as its parameters say.

    Raises
    ------
    InputError
        If a parameter is refused.
    """

    def __init__(self) -> None:
        super().__init__("disturber")
        self.names = {
            name: self._fixed(name, default, text)
            for name, default, text in (
                ("input", "pose_measured", "Topic that is listened to."),
                ("output", "pose", "Topic that is published."),
                ("kind", "geometry_msgs/msg/PoseWithCovarianceStamped", f"Type of both: {', '.join(KINDS)}."),
            )
        }
        if self.names["kind"] not in KINDS:
            raise InputError(f"kind: expected one of {', '.join(KINDS)}, found '{self.names['kind']}'")
        if self.names["input"] == self.names["output"]:
            raise InputError(f"output: expected another topic than input, found '{self.names['output']}' for both")
        kind, self._inner = KINDS[self.names["kind"]]
        self._disturber = Disturber(DisturberSettings())
        parameters = SettingsParameters(self, DisturberSettings(), lambda settings: None, self._disturber.apply)
        self._disturber.apply(parameters.current)
        self._publisher = self.create_publisher(kind, self.names["output"], RING_PUBLISHER)
        self.create_subscription(kind, self.names["input"], self._relay, RING_LOCKSTEP)

    def _fixed(self, name: str, default: str, text: str) -> str:
        return str(self.declare_parameter(name, default, ParameterDescriptor(description=text, read_only=True)).value)

    @property
    def told(self) -> str:
        """What was done so far, in one line."""
        counts = self._disturber.counts
        return (
            f"{counts.received} messages in, {counts.sent} out; {counts.lost} lost, {counts.duplicated} duplicated, "
            f"{counts.reordered} overtaken, {counts.not_finite} not finite; {self._disturber.held} held back"
        )

    def _relay(self, message: Any) -> None:
        pose = self._inner(message)
        q = pose.orientation
        try:
            heading = quaternion_to_heading(q.x, q.y, q.z, q.w)
        except InputError:
            heading = float("nan")  # it came so: not ours to refuse
        sample = PoseSample(
            to_nanoseconds(message.header.stamp), (pose.position.x, pose.position.y, heading), payload=message
        )
        for sent in self._disturber.step(sample):
            self._publisher.publish(self._message(sample, sent))

    def _message(self, came: PoseSample, sent: PoseSample) -> Any:
        if sent is came:
            return came.payload
        message: Any = copy.deepcopy(sent.payload)
        message.header.stamp = from_nanoseconds(sent.stamp)
        pose = self._inner(message)
        north, east, heading = sent.position
        pose.position.x, pose.position.y = north, east
        if heading == heading:
            numbers = heading_to_quaternion(heading)
        else:
            numbers = (float("nan"),) * 4
        sign = -1.0 if sent.other_cover else 1.0
        for name, number in zip("xyzw", numbers, strict=True):
            setattr(pose.orientation, name, sign * number)
        return message


def run() -> int:
    """Relay until SIGINT or SIGTERM; return the exit code."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stop = Stop()
    executor = RingExecutor()
    try:
        node = DisturberNode()
        executor.add_node(node)
        print(f"{node.names['input']} -> {node.names['output']}", flush=True)
        while not stop.requested:
            executor.spin_once(timeout_sec=0.1)
        print(node.told, flush=True)
        node.destroy_node()
    except DpError as error:
        print(f"disturber: {error}", file=sys.stderr, flush=True)
        return 1
    finally:
        executor.shutdown()
        rclpy.try_shutdown()
    return 0


def main() -> None:
    """Run the disturber and exit the process."""
    sys.exit(run())


if __name__ == "__main__":
    main()
