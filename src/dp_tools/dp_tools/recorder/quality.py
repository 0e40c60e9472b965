"""Quality of service of a recording subscription: whatever its publishers offer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

# Messages of one topic that may wait for the recorder. Fast DDS holds at most 5000 samples a reader: with a larger
# depth a full reader refuses new samples, so that the gap in the sequence numbers comes later and is larger.
DEPTH = 5000


def matching_quality(offered: Sequence[QoSProfile]) -> QoSProfile:
    """Return the strictest profile that every publisher in ``offered`` can serve.

    One best-effort publisher makes the subscription best effort, one volatile publisher makes it volatile: a
    subscription that asks for more than a publisher offers hears nothing from it.
    """
    reliable = all(quality.reliability == ReliabilityPolicy.RELIABLE for quality in offered)
    latched = all(quality.durability == DurabilityPolicy.TRANSIENT_LOCAL for quality in offered)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def describe_quality(quality: QoSProfile) -> dict[str, Any]:
    """Return a profile in the words of rosbag2's metadata, version 9."""
    return {
        "history": quality.history.name.lower(),
        "depth": quality.depth,
        "reliability": quality.reliability.name.lower(),
        "durability": quality.durability.name.lower(),
        "deadline": _duration(quality.deadline),
        "lifespan": _duration(quality.lifespan),
        "liveliness": quality.liveliness.name.lower(),
        "liveliness_lease_duration": _duration(quality.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": quality.avoid_ros_namespace_conventions,
    }


def _duration(duration: Duration) -> dict[str, int]:
    sec, nsec = divmod(duration.nanoseconds, 1_000_000_000)
    return {"sec": sec, "nsec": nsec}
