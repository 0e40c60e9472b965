"""metadata.yaml of a rosbag2 bag, version 9, as ROS 2 Jazzy writes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

VERSION = 9


@dataclass(frozen=True)
class TopicInfo:
    """What a bag says of a topic.

    Attributes
    ----------
    name, kind
        Topic and message type, e.g. ``nav_msgs/msg/Odometry``.
    type_hash
        RIHS01 text; empty when not known.
    offered_quality
        One mapping a publisher, in rosbag2's words.
    """

    name: str
    kind: str
    type_hash: str = ""
    offered_quality: tuple[Mapping[str, Any], ...] = field(default=())

    def quality_text(self) -> str:
        """Return ``offered_quality`` as YAML text, as rosbag2 keeps it with a channel."""
        return to_yaml([dict(quality) for quality in self.offered_quality]) if self.offered_quality else ""


@dataclass(frozen=True)
class FileInfo:
    """What a bag says of one of its MCAP files.

    Attributes
    ----------
    name
        Without a folder.
    start, end
        First and last log time, ns; zeros without a message.
    message_count
        Messages in it.
    """

    name: str
    start: int
    end: int
    message_count: int


def bag_metadata(
    files: Sequence[FileInfo],
    topics: Sequence[tuple[TopicInfo, int]],
    custom_data: Mapping[str, str],
) -> dict[str, Any]:
    """Return the content under ``rosbag2_bagfile_information``.

    Parameters
    ----------
    files
        MCAP files in order of recording.
    topics
        Topics with their numbers of messages in all files.
    custom_data
        What else there is to say.
    """
    full = [file for file in files if file.message_count]
    start = min((file.start for file in full), default=0)
    end = max((file.end for file in full), default=0)
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(file.message_count for file in files),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.kind,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [dict(quality) for quality in topic.offered_quality],
                    "type_description_hash": topic.type_hash,
                },
                "message_count": messages,
            }
            for topic, messages in topics
        ],
        # Chunks are compressed inside the file; this is about compression of files or messages by rosbag2.
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [
            {
                "path": file.name,
                "starting_time": {"nanoseconds_since_epoch": file.start},
                "duration": {"nanoseconds": file.end - file.start},
                "message_count": file.message_count,
            }
            for file in files
        ],
        "custom_data": dict(custom_data) or None,
        "ros_distro": "jazzy",
    }


class _Dumper(yaml.SafeDumper):
    """SafeDumper without anchors: rosbag2's reader need not know them."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def to_yaml(value: Any) -> str:
    """Return ``value`` as YAML text."""
    text: str = yaml.dump(value, Dumper=_Dumper, sort_keys=False, default_flow_style=False)
    return text
