"""Writing messages of one bag to another."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dp_tools.bags.bag import BagTopic
from dp_tools.bags.errors import BagError
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter

# The writer makes these itself.
_OWN_RECORD = "rosbag2"


class BagCopy:
    """A new bag that takes over messages, attachments and records of another, in the order in which they are given.

    Parameters
    ----------
    folder
        Of the new bag.
    overwrite
        True to replace a bag that is there.

    Raises
    ------
    RecordingRefusedError
        If the folder holds something already or cannot be written.
    """

    def __init__(self, folder: Path, overwrite: bool = False) -> None:
        self.folder = folder
        self._writer = BagWriter(folder, overwrite)
        self._channels: dict[tuple[str, str], int] = {}
        self._attached: set[str] = set()
        self._described: dict[str, Mapping[str, str]] = {}
        self.count = 0
        """Messages written."""

    def add_topic(self, topic: BagTopic) -> int:
        """Add a topic, if it is not there, and return its channel. Raises BagError if it is not one of ROS 2."""
        key = topic.name, topic.kind
        if key not in self._channels:
            if topic.encoding != "cdr" or topic.definition_encoding != "ros2msg":
                raise BagError(
                    f"{topic.name}: expected messages in cdr defined in ros2msg, "
                    f"found {topic.encoding} and {topic.definition_encoding}"
                )
            info = TopicInfo(topic.name, topic.kind, topic.type_hash, topic.offered_quality)
            self._channels[key] = self._writer.add_topic(info, topic.definition)
        return self._channels[key]

    def write(self, topic: BagTopic, sequence: int, log_time: int, publish_time: int, data: bytes) -> None:
        """Write a message; times in ns. Raises RecordingStoppedError."""
        channel = self._channels.get((topic.name, topic.kind)) or self.add_topic(topic)
        self._writer.write(channel, data, log_time, publish_time, sequence)
        self.count += 1

    def attach(self, attachment: Any) -> None:
        """Take over an attachment, unless it only repeats one: every file of a split bag has them all.

        Raises
        ------
        RecordingStoppedError
            If the disk is full or fails.
        """
        if attachment.log_time > attachment.create_time and attachment.name in self._attached:
            return
        self._attached.add(attachment.name)
        self._writer.attach(attachment.name, attachment.media_type, attachment.data, attachment.log_time)

    def describe(self, record: Any) -> None:
        """Take over a metadata record. Raises RecordingStoppedError."""
        if record.name != _OWN_RECORD and self._described.get(record.name) != record.metadata:
            self._described[record.name] = record.metadata
            self._writer.describe(record.name, record.metadata)

    def close(self, custom_data: Mapping[str, str]) -> None:
        """Finish the bag. Raises RecordingStoppedError."""
        self._writer.close(custom_data)


def custom_data(metadata: Mapping[str, Any] | None) -> dict[str, str]:
    """Return what a bag's metadata.yaml says under ``custom_data``."""
    found = (metadata or {}).get("custom_data")
    return {str(name): str(value) for name, value in found.items()} if isinstance(found, dict) else {}
