"""A bag of one file or several, read as one."""

from __future__ import annotations

from array import array
from collections import Counter, OrderedDict
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema
from numpy.typing import NDArray

from dp_tools.bags.errors import BagError, CutOffError, DamageError
from dp_tools.bags.files import BagFiles, bag_files
from dp_tools.bags.mcap_records import MAGIC, MESSAGE_HEAD, RawRecord, parsed, raw_records, records_in, unpacked
from dp_tools.bags.yaml_text import YAML_ERRORS, from_yaml

# Unpacked chunks kept for messages asked for one by one; those of one time are in a few neighbouring chunks.
_CHUNKS_KEPT = 32
# Times are kept as int64, which is enough until the year 2262.
_LATEST = (1 << 63) - 1


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Attributes
    ----------
    name, kind
        Topic and message type, e.g. ``nav_msgs/msg/Odometry``.
    encoding
        Of its messages; ``cdr`` in bags of ROS 2.
    definition
        Text of the message definition, and its encoding (``ros2msg`` in bags of ROS 2).
    quality_text
        Offered quality of service, YAML as rosbag2 writes it.
    type_hash
        RIHS01 text; empty when not known.
    """

    name: str
    kind: str
    encoding: str
    definition: str
    definition_encoding: str
    quality_text: str
    type_hash: str

    @cached_property
    def offered_quality(self) -> tuple[Mapping[str, Any], ...]:
        """One mapping a publisher, in rosbag2's words; empty where the bag tells none."""
        try:
            found = from_yaml(self.quality_text) if self.quality_text else None
        except YAML_ERRORS:
            return ()
        return tuple(one for one in found if isinstance(one, dict)) if isinstance(found, list) else ()


@dataclass(frozen=True)
class Messages:
    """All messages of a bag in the order of its files; arrays of one length.

    Attributes
    ----------
    topic
        Number of the topic in :attr:`Bag.topics`.
    log_time, publish_time
        ns.
    sequence
        Number that the publisher gave the message; 0 where none is known.
    """

    topic: NDArray[np.int64]
    log_time: NDArray[np.int64]
    publish_time: NDArray[np.int64]
    sequence: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.topic)


@dataclass(frozen=True)
class _Block:
    """Where a chunk, or a message outside of any, is."""

    stream: IO[bytes]
    path: Path
    start: int
    is_chunk: bool


class Bag:
    """An open bag. Use :func:`open_bag`, as a context.

    Attributes
    ----------
    files
        What it consists of.
    topics
        In the order in which they appear.
    attachments, records
        Files that go with it and metadata records, in the order of the files.
    messages
        Times and topics of all messages.
    cut_off
        By file: where and why it ends before its end. Everything before is in ``messages``.
    chunks
        Number of chunks by compression, ``none`` for none.
    unpacked_size
        Bytes of what is in all chunks.
    """

    def __init__(self, files: BagFiles) -> None:
        self.files = files
        self.topics: list[BagTopic] = []
        self.attachments: list[Attachment] = []
        self.records: list[Metadata] = []
        self.messages = Messages(*(np.empty(0, dtype=np.int64) for _ in range(4)))
        self.cut_off: dict[Path, CutOffError] = {}
        self.chunks: Counter[str] = Counter()
        self.unpacked_size = 0
        self._open = ExitStack()
        self._blocks: list[_Block] = []
        self._where: tuple[Any, Any, Any] = (array("q"), array("q"), array("q"))  # block, begin, end
        self._unpacked: OrderedDict[int, bytes] = OrderedDict()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._open.close()

    def data(self, row: int) -> bytes:
        """Return the serialized message ``row``. Raises BagError if the file has changed meanwhile."""
        blocks, begins, ends = self._where
        return self._block(blocks[row])[begins[row] : ends[row]]

    def _block(self, number: int) -> bytes:
        found = self._unpacked.get(number)
        if found is not None:
            self._unpacked.move_to_end(number)
            return found
        block = self._blocks[number]
        try:
            size = block.path.stat().st_size
            raw = next(raw_records(block.stream, size, block.start))
            data = unpacked(parsed(raw), raw.start) if block.is_chunk else raw.content
        except (OSError, DamageError) as error:
            raise BagError(f"{block.path}: cannot be read any more: {error}") from error
        self._unpacked[number] = data
        if len(self._unpacked) > _CHUNKS_KEPT:
            self._unpacked.popitem(last=False)
        return data

    def _read(self, progress: Callable[[int], None]) -> None:
        columns = tuple(array("q") for _ in range(4))
        done = 0

        def show(at: int) -> None:
            progress(done + at)

        for path in self.files.files:
            try:
                stream = self._open.enter_context(path.open("rb"))
                _FileReader(self, stream, path, columns).read(show)
                done += path.stat().st_size
            except CutOffError as error:
                self.cut_off[path] = error
            except DamageError as error:
                raise BagError(f"{path}: damaged: {error}; dp bag check --repair may help") from error
            except OSError as error:
                raise BagError(f"{path}: cannot be read: {error.strerror or error}") from error
        self.messages = Messages(*(np.frombuffer(column, dtype=np.int64) for column in columns))


class _FileReader:
    """Reads the data section of one file into a bag."""

    def __init__(self, bag: Bag, stream: IO[bytes], path: Path, columns: tuple[Any, ...]) -> None:
        self._bag = bag
        self._stream = stream
        self._path = path
        self._columns = columns
        self._schemas: dict[int, Schema] = {}
        self._topics: dict[int, int] = {}  # of the bag, by channel of the file

    def read(self, progress: Callable[[int], None]) -> None:
        size = self._path.stat().st_size
        self._stream.seek(0)
        magic = self._stream.read(len(MAGIC))
        if magic != MAGIC[: len(magic)] or not magic:
            raise BagError(f"{self._path}: expected an MCAP file, found something else")
        for raw in raw_records(self._stream, size):
            if raw.opcode == Opcode.CHUNK:
                self._chunk(raw)
                progress(raw.end)
            elif raw.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(raw)
            elif raw.opcode == Opcode.MESSAGE:
                self._message(raw)
            elif raw.opcode == Opcode.ATTACHMENT:
                self._bag.attachments.append(parsed(raw))
            elif raw.opcode == Opcode.METADATA:
                self._bag.records.append(parsed(raw))
            elif raw.opcode in (Opcode.DATA_END, Opcode.FOOTER):
                return

    def _chunk(self, raw: RawRecord) -> None:
        chunk = parsed(raw)
        data = unpacked(chunk, raw.start)
        self._bag.chunks[chunk.compression or "none"] += 1
        self._bag.unpacked_size += len(data)
        block = len(self._bag._blocks)
        self._bag._blocks.append(_Block(self._stream, self._path, raw.start, True))
        for opcode, begin, end in records_in(data, raw.start):
            if opcode == Opcode.MESSAGE:
                self._note(block, data, begin, end, raw.start)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(RawRecord(opcode, raw.start, data[begin:end]))

    def _message(self, raw: RawRecord) -> None:
        if len(raw.content) < MESSAGE_HEAD.size:
            raise DamageError(raw.start, f"message of {len(raw.content)} bytes")
        self._bag._blocks.append(_Block(self._stream, self._path, raw.start, False))
        self._note(len(self._bag._blocks) - 1, raw.content, 0, len(raw.content), raw.start)

    def _note(self, block: int, data: bytes, begin: int, end: int, at: int) -> None:
        channel, sequence, log_time, publish_time = MESSAGE_HEAD.unpack_from(data, begin)
        topic = self._topics.get(channel)
        if topic is None:
            raise DamageError(at, f"message of channel {channel}, which is not defined before")
        expect_time(log_time, publish_time, at)
        for column, value in zip(self._columns, (topic, log_time, publish_time, sequence), strict=True):
            column.append(value)
        for column, value in zip(self._bag._where, (block, begin + MESSAGE_HEAD.size, end), strict=True):
            column.append(value)

    def _define(self, raw: RawRecord) -> None:
        record = parsed(raw)
        if isinstance(record, Schema):
            self._schemas[record.id] = record
            return
        topic = bag_topic(record, self._schemas, raw.start)
        known = self._bag.topics
        if topic not in known:
            known.append(topic)
        self._topics[record.id] = known.index(topic)


def expect_time(log_time: int, publish_time: int, at: int) -> None:
    """Raise DamageError if a message at byte ``at`` is of a time (ns) that is kept nowhere."""
    if log_time > _LATEST or publish_time > _LATEST:
        raise DamageError(at, f"message with the time {max(log_time, publish_time)} ns")


def bag_topic(channel: Channel, schemas: Mapping[int, Schema], at: int) -> BagTopic:
    """Return the topic of a channel at byte ``at``. Raises DamageError if its schema is missing or no text."""
    schema = schemas.get(channel.schema_id)
    if schema is None:
        raise DamageError(at, f"channel {channel.id} ({channel.topic}): its schema {channel.schema_id} is not there")
    try:
        definition = schema.data.decode()
    except UnicodeDecodeError as error:
        raise DamageError(at, f"schema {schema.name}: no text") from error
    return BagTopic(
        channel.topic,
        schema.name,
        channel.message_encoding,
        definition,
        schema.encoding,
        channel.metadata.get("offered_qos_profiles", ""),
        channel.metadata.get("topic_type_hash", ""),
    )


def open_bag(path: Path, progress: Callable[[int], None] = lambda done: None) -> Bag:
    """Open a bag and find all its messages.

    Parameters
    ----------
    path
        Its folder, the folder of a run, or one MCAP file.
    progress
        Called with the bytes read so far.

    Raises
    ------
    BagError
        If it cannot be read or is damaged in the middle. A file that ends early is read as far as it goes.
    """
    bag = Bag(bag_files(path))
    try:
        bag._read(progress)
    except BaseException:
        bag._open.close()
        raise
    return bag
