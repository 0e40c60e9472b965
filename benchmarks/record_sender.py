"""A sender for the recorder's benchmark: one message, already serialized, over and over, so many a second.

What is published is what a node would publish, but it costs the sender next to nothing: rclpy takes serialized data as
it is.
"""

from __future__ import annotations

import sys
import time
from itertools import count

import rclpy
from dp_msgs.msg import ThrusterFeedback
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile
from rclpy.serialization import serialize_message

from dp_node import RING_PUBLISHER
from marine_model import load_vessel

# Messages of one moment; between two of them the sender sleeps.
_PERIOD = 0.002
_PATIENCE = 60.0


def feedback(vessel: str) -> bytes:
    """Return the serialized feedback of a vessel's thrusters."""
    names = list(load_vessel(vessel).thruster_names)
    zeros = [0.0] * len(names)
    fields = ("shaft_speed", "torque", "power", "azimuth", "azimuth_rate", "pitch_ratio")
    message = ThrusterFeedback(name=names, **dict.fromkeys(fields, zeros))
    message.header.frame_id = "base_link_frd"
    return bytes(serialize_message(message))


def main(topic: str, vessel: str, rate: float, number: int, depth: int) -> int:
    """Send ``number`` messages, ``rate`` a second (0: as fast as it goes), once somebody listens; 1 if nobody does."""
    rclpy.init()
    node = Node(topic.rpartition("/")[2], start_parameter_services=False, enable_rosout=False)
    quality = QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=RING_PUBLISHER.reliability,
        durability=RING_PUBLISHER.durability,
    )
    publisher = node.create_publisher(ThrusterFeedback, topic, quality)
    deadline = time.monotonic() + _PATIENCE
    while publisher.get_subscription_count() == 0:
        if time.monotonic() > deadline:
            return 1
        time.sleep(0.01)
    data, publish = feedback(vessel), publisher.publish
    begin = time.monotonic()
    sent = 0
    for tick in count(1):
        due = number if rate == 0.0 else min(number, int(tick * _PERIOD * rate))
        while sent < due:
            publish(data)
            sent += 1
        if sent == number:
            break
        time.sleep(max(0.0, begin + tick * _PERIOD - time.monotonic()))
    seconds = time.monotonic() - begin
    publisher.wait_for_all_acked(Duration(seconds=_PATIENCE))
    print(f"{seconds:.6f} {time.process_time():.6f}", flush=True)
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4]), int(sys.argv[5])))
