"""A bag as re-execution needs it: serialized messages by topic with their publish times, and everything attached."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from dp_tools.reexecution.errors import ReexecutionError
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
    messages
        In order of publish time.
    """

    name: str
    kind: str
    definition: str
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
        In order of time.
    records
        Metadata records by name.
    cut_short
        True if a file ends in the middle: its recorder was killed. What was written before is there.
    """

    path: Path
    topics: dict[str, Topic]
    attachments: list[Attached]
    records: Mapping[str, Mapping[str, str]]
    cut_short: bool = False

    @property
    def start(self) -> int:
        """Log time of the first message, ns."""
        return min((m.logged for topic in self.topics.values() for m in topic.messages[:1]), default=0)

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


def read_recording(path: Path) -> Recording:
    """Return everything in a bag, given its folder or one of its MCAP files; one that was not closed is read too.

    Raises
    ------
    ReexecutionError
        If there is no bag, or it cannot be read.
    """
    files = [path] if path.is_file() else sorted(path.glob("*.mcap"), key=_place)
    if not files:
        raise ReexecutionError(f"{path}: expected a bag, found no .mcap file")
    recording = Recording(path, {}, [], {})
    records: dict[str, Mapping[str, str]] = {}
    for file in files:
        try:
            _read(file, recording, records)
        except (OSError, McapError) as error:
            raise ReexecutionError(f"{file}: cannot be read: {error}") from error
    recording.records = records
    for topic in recording.topics.values():
        topic.messages.sort(key=lambda message: message.published)
    recording.attachments.sort(key=lambda attached: attached.time)
    return recording


def _place(file: Path) -> tuple[int, str]:
    """Return what sorts the files of a split bag: ``bag_10`` comes after ``bag_9``."""
    number = file.stem.rpartition("_")[2]
    return (int(number) if number.isdigit() else 0, file.name)


def _read(file: Path, recording: Recording, records: dict[str, Mapping[str, str]]) -> None:
    schemas: dict[int, Schema] = {}
    channels: dict[int, Topic] = {}
    seen = {(one.name, one.time) for one in recording.attachments}
    with file.open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Message):
                    message = Recorded(record.publish_time, record.log_time, record.sequence, record.data)
                    channels[record.channel_id].messages.append(message)
                elif isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel) and record.id not in channels:
                    schema = schemas[record.schema_id]
                    made = Topic(record.topic, schema.name, schema.data.decode(errors="replace"))
                    channels[record.id] = recording.topics.setdefault(record.topic, made)
                elif isinstance(record, Attachment) and (record.name, record.log_time) not in seen:
                    # A bag that is split may have them in every file.
                    recording.attachments.append(Attached(record.name, record.log_time, record.data))
                elif isinstance(record, Metadata):
                    records.setdefault(record.name, record.metadata)
        except EndOfFile:
            recording.cut_short = True
