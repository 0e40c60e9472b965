"""Small bags made by hand, by the recorder's own writer."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

from dp_node import RING, RING_PUBLISHER
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.quality import describe_quality
from dp_tools.recorder.schemas import full_definition

START = 1_700_000_000_000_000_000  # ns since 1970
STRING = "std_msgs/msg/String"
CLOCK = "rosgraph_msgs/msg/Clock"
# Publishers do not tell their history to others.
_UNTOLD: dict[str, Any] = {"history": "unknown", "depth": 0}
RELIABLE = {**describe_quality(RING), **_UNTOLD}
RING_TOLD = {**describe_quality(RING_PUBLISHER), **_UNTOLD}
LATCHED = describe_quality(QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))

Message = tuple[str, float, Any]


def text(content: str) -> bytes:
    """A serialized std_msgs/String."""
    data = content.encode() + b"\0"
    # Filled up to whole words, as the middleware does.
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data + bytes(-len(data) % 4)


def clock(seconds: float) -> bytes:
    """A serialized rosgraph_msgs/Clock."""
    sec, nanosec = divmod(round(seconds * 1e9), 1_000_000_000)
    return b"\0\1\0\0" + struct.pack("<iI", sec, nanosec)


def as_bytes(content: Any) -> bytes:
    """What is written for a content: bytes as they are, texts as String, messages serialized."""
    if isinstance(content, bytes):
        return content
    return text(content) if isinstance(content, str) else bytes(serialize_message(content))


def make_bag(
    folder: Path,
    messages: Iterable[Message],
    kinds: Mapping[str, str] | None = None,
    quality: Mapping[str, dict[str, Any]] | None = None,
    attachments: Mapping[str, bytes] | None = None,
    chunk_size: int = 1 << 20,
    delay: float = 0.001,
    definitions: Mapping[str, str] | None = None,
) -> Path:
    """Write messages (topic, publish time in s from START, content) in the order given; logged ``delay`` s later.

    ``definitions`` are of kinds that are not installed.
    """
    writer = BagWriter(folder, chunk_size=chunk_size)
    for name, data in (attachments or {}).items():
        writer.attach(name, "application/yaml", data, START)
    channels: dict[str, int] = {}
    numbers: dict[str, int] = {}
    for topic, seconds, content in messages:
        if topic not in channels:
            kind = (kinds or {}).get(topic, STRING)
            offered = (quality or {}).get(topic, RELIABLE)
            definition = (definitions or {}).get(kind) or full_definition(kind)
            channels[topic] = writer.add_topic(TopicInfo(topic, kind, "", (offered,)), definition)
        numbers[topic] = numbers.get(topic, 0) + 1
        at = START + round(seconds * 1e9)
        writer.write(channels[topic], as_bytes(content), at + round(delay * 1e9), at, numbers[topic])
    writer.close()
    return folder


def text_in(data: bytes) -> str:
    """The text of a serialized std_msgs/String."""
    return data[8 : 7 + int.from_bytes(data[4:8], "little")].decode()
