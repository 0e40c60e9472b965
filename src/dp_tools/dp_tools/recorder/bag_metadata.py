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


def bag_metadata(
    file_name: str,
    topics: Sequence[tuple[TopicInfo, int]],
    time_span: tuple[int, int],
    custom_data: Mapping[str, str],
) -> dict[str, Any]:
    """Return the content under ``rosbag2_bagfile_information``.

    Parameters
    ----------
    file_name
        Name of the one MCAP file.
    topics
        Topics with their numbers of messages.
    time_span
        First and last log time, ns.
    custom_data
        What else there is to say.
    """
    start, end = time_span
    count = sum(messages for _, messages in topics)
    starting_time = {"nanoseconds_since_epoch": start}
    duration = {"nanoseconds": end - start}
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": starting_time,
        "message_count": count,
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
        "relative_file_paths": [file_name],
        "files": [
            {"path": file_name, "starting_time": starting_time, "duration": duration, "message_count": count},
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
