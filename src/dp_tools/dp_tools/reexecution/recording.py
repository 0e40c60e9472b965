"""A bag as re-execution needs it: serialized messages by topic with their publish times, and everything attached."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dp_tools.bags.bag import Bag
from dp_tools.run_bag import RUN_RECORD

_RING_TOPIC = "thruster_feedback"


@dataclass(frozen=True, slots=True)
class Recorded:
    """One serialized message.

    Parameters
    ----------
    published, logged
        Wall-clock time of the publisher and of the recorder, ns.
    number
        The publisher's number, from 1; 0 where it is not known.
    data
        CDR.
    """

    published: int
    logged: int
    number: int
    data: bytes


@dataclass
class Topic:
    """One topic of a bag.

    Parameters
    ----------
    name
        Full name.
    kind
        Message type, e.g. ``nav_msgs/msg/Odometry``.
    definition
        Full text of the message definition (ros2msg), as recorded.
    offered_quality
        Of its publishers, in rosbag2's words.
    messages
        In order of publish time.
    """

    name: str
    kind: str
    definition: str
    offered_quality: tuple[Mapping[str, Any], ...] = ()
    messages: list[Recorded] = field(default_factory=list)


@dataclass(frozen=True)
class Attached:
    """One attachment; ``time`` (ns) says when it was taken."""

    name: str
    time: int
    data: bytes


@dataclass
class Recording:
    """A whole bag.

    Parameters
    ----------
    path
        Folder or file.
    topics
        By full name.
    attachments
        In order of time, each once.
    records
        Metadata records by name.
    start
        Log time of the first message, ns.
    """

    path: Path
    topics: dict[str, Topic]
    attachments: list[Attached]
    records: Mapping[str, Mapping[str, str]]
    start: int

    @property
    def in_process(self) -> bool:
        """Whether a run without middleware left this bag: it holds what the run logged, not whole messages."""
        return RUN_RECORD in self.records

    def attachment(self, name: str) -> Attached | None:
        """Return the first attachment of that name."""
        return next((one for one in self.attachments if one.name == name), None)

    def namespaces(self) -> list[str]:
        """Return the namespaces of the graphs in it, each with a slash at its end."""
        ends = f"/{_RING_TOPIC}"
        return sorted(name.removesuffix(_RING_TOPIC) for name in self.topics if name.endswith(ends))


def recording_of(bag: Bag) -> Recording:
    """Return everything in an open bag. Raises BagError if a file of it has changed meanwhile."""
    by_name: dict[str, Topic] = {}
    # A topic may be described twice, with publishers that offer more and less.
    topics = [
        by_name.setdefault(one.name, Topic(one.name, one.kind, one.definition, one.offered_quality))
        for one in bag.topics
    ]
    found = bag.messages
    rows = zip(
        found.topic.tolist(),
        found.publish_time.tolist(),
        found.log_time.tolist(),
        found.sequence.tolist(),
        strict=True,
    )
    for row, (number, published, logged, sequence) in enumerate(rows):
        topics[number].messages.append(Recorded(published, logged, sequence, bag.data(row)))
    for topic in by_name.values():
        topic.messages.sort(key=lambda message: message.published)
    attached = {(one.name, one.log_time): Attached(one.name, one.log_time, one.data) for one in bag.attachments}
    return Recording(
        bag.files.path,
        by_name,
        sorted(attached.values(), key=lambda one: one.time),
        {record.name: record.metadata for record in reversed(bag.records)},
        min(found.log_time.tolist(), default=0),
    )
