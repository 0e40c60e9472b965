"""What can be had of a damaged MCAP file: every message whose bytes are known to be right."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, TypeAlias

import lz4.frame
import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema

from dp_tools.bags.bag import BagTopic, bag_topic, expect_time
from dp_tools.bags.errors import CutOffError, DamageError
from dp_tools.bags.mcap_records import (
    FIRST_PRIVATE,
    MAGIC,
    MESSAGE_HEAD,
    RECORD_HEAD,
    RawRecord,
    parsed,
    raw_records,
    records_in,
    unpacked,
)

# Opcode, length, start, end, size, checksum: then the name of the compression. By that a chunk is found again.
_BEFORE_COMPRESSION = RECORD_HEAD.size + 8 + 8 + 8 + 4
_CHUNK_HEAD = struct.Struct("<QII")  # size and checksum of what is in it, length of the name of the compression
_COMPRESSIONS = (b"\x04\0\0\0zstd", b"\x03\0\0\0lz4")
_WINDOW = 1 << 24


@dataclass(frozen=True)
class SavedMessage:
    """One message with its topic; times in ns."""

    topic: BagTopic
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


Saved: TypeAlias = SavedMessage | Attachment | Metadata


class Salvage:
    """Reads one file as far as it can be read, and goes on behind what cannot.

    Parameters
    ----------
    path
        The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, Schema] = {}
        self._topics: dict[int, BagTopic] = {}
        self.damage: list[DamageError] = []
        """What could not be read."""

    def saved(self, progress: Callable[[int], None] = lambda done: None) -> Iterator[Saved]:
        """Yield messages, attachments and metadata in the order of the file. Raises OSError."""
        with self._path.open("rb") as stream:
            size = self._path.stat().st_size
            self._learn_from_summary(stream, size)
            at: int | None = len(MAGIC)
            while at is not None:
                raw: RawRecord | None = None
                try:
                    for raw in raw_records(stream, size, at):
                        if raw.opcode in (Opcode.DATA_END, Opcode.FOOTER):
                            return
                        yield from self._record(raw)
                        at = raw.end
                        progress(at)
                    return
                except DamageError as error:
                    self.damage.append(error)
                    cut = isinstance(error, CutOffError)
                    broken_at = at
                    if cut or raw is None or not _begins_a_record(stream, raw.end, size):
                        at = _next_chunk(stream, broken_at + 1, size)
                    else:
                        at = raw.end
                    if at is None and cut:
                        yield from self._cut_chunk(stream, broken_at)

    def _learn_from_summary(self, stream: IO[bytes], size: int) -> None:
        """Take schemas and channels out of the summary, if it can be read: those of a broken chunk are there too."""
        footer_size = RECORD_HEAD.size + 20
        try:
            footer = parsed(next(raw_records(stream, size, max(0, size - len(MAGIC) - footer_size))))
            if 0 < getattr(footer, "summary_start", 0) < size:
                for raw in raw_records(stream, size, footer.summary_start):
                    if raw.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                        self._define(raw)
        except DamageError:
            return

    def _record(self, raw: RawRecord) -> Iterator[Saved]:
        if raw.opcode >= FIRST_PRIVATE:
            return
        record = parsed(raw)
        if isinstance(record, Chunk):
            yield from self._messages(unpacked(record, raw.start), raw.start)
        elif isinstance(record, Message):
            yield self._message(raw.content, raw.start)
        elif isinstance(record, Schema | Channel):
            self._define(raw)
        elif isinstance(record, Attachment | Metadata):
            yield record

    def _messages(self, data: bytes, at: int) -> Iterator[SavedMessage]:
        for opcode, begin, end in records_in(data, at):
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(RawRecord(opcode, at, data[begin:end]))
            elif opcode == Opcode.MESSAGE:
                try:
                    message = self._message(data[begin:end], at)
                except DamageError as error:
                    # The others of the chunk are right: its checksum is, or nothing else is wrong with it.
                    if error.args not in [known.args for known in self.damage[-1:]]:
                        self.damage.append(error)
                    continue
                yield message

    def _message(self, content: bytes, at: int) -> SavedMessage:
        channel, sequence, log_time, publish_time = MESSAGE_HEAD.unpack_from(content)
        topic = self._topics.get(channel)
        if topic is None:
            raise DamageError(at, f"message of channel {channel}, which is not defined before")
        expect_time(log_time, publish_time, at)
        return SavedMessage(topic, sequence, log_time, publish_time, content[MESSAGE_HEAD.size :])

    def _define(self, raw: RawRecord) -> None:
        record: Any = parsed(raw)
        if raw.opcode == Opcode.SCHEMA:
            self._schemas[record.id] = record
        else:
            self._topics[record.id] = bag_topic(record, self._schemas, raw.start)

    def _cut_chunk(self, stream: IO[bytes], at: int) -> Iterator[SavedMessage]:
        """Yield the messages at the beginning of a chunk whose end is missing; what is there is as it was written."""
        stream.seek(at)
        data = stream.read(_WINDOW)
        if len(data) < _BEFORE_COMPRESSION + 4 or data[0] != Opcode.CHUNK:
            return
        size, crc, length = _CHUNK_HEAD.unpack_from(data, RECORD_HEAD.size + 16)
        begin = _BEFORE_COMPRESSION + 4
        part = _unpacked_part(data[begin : begin + length], data[begin + length + 8 :])
        if len(part) > size or (len(part) == size and crc not in (0, zlib.crc32(part))):
            return
        try:
            yield from self._messages(part, at)
        except DamageError:
            return


def _unpacked_part(compression: bytes, data: bytes) -> bytes:
    """Return as much as can be unpacked."""
    decompress: Callable[[bytes], bytes]
    if compression == b"zstd":
        decompress = zstandard.ZstdDecompressor().decompressobj().decompress
    elif compression == b"lz4":
        decompress = lz4.frame.LZ4FrameDecompressor().decompress
    else:
        return data if compression == b"" else b""
    found = bytearray()
    # Bit by bit, so that what comes before an error is kept.
    for start in range(0, len(data), 4096):
        try:
            found += decompress(data[start : start + 4096])
        except (zstandard.ZstdError, RuntimeError, EOFError):
            break
    return bytes(found)


def _begins_a_record(stream: IO[bytes], at: int, size: int) -> bool:
    """Return whether a sound record begins at byte ``at``."""
    try:
        parsed(next(raw_records(stream, size, at)))
    except DamageError:
        return False
    return True


def _next_chunk(stream: IO[bytes], at: int, size: int) -> int | None:
    """Return where the next whole, compressed chunk begins; None if there is none."""
    while at < size:
        stream.seek(at)
        window = stream.read(_WINDOW)
        for place in _likely_chunks(window):
            try:
                raw = next(raw_records(stream, size, at + place))
                if raw.opcode == Opcode.CHUNK:
                    unpacked(parsed(raw), raw.start)
                    return at + place
            except DamageError:
                continue
        if len(window) < _WINDOW:
            return None
        at += _WINDOW - 64  # a head may lie across the end of the window
    return None


def _likely_chunks(window: bytes) -> list[int]:
    """Return where a chunk may begin, by its opcode and the name of its compression."""
    found = []
    for name in _COMPRESSIONS:
        place = window.find(name)
        while place >= 0:
            start = place - _BEFORE_COMPRESSION
            if start >= 0 and window[start] == Opcode.CHUNK:
                found.append(start)
            place = window.find(name, place + 1)
    return sorted(found)
