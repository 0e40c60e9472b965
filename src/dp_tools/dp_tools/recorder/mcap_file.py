"""An MCAP file, written chunk by chunk; a chunk is in the file whole or not at all.

The library's own writer cannot go on once a write has failed: its indexes then speak of data that is not there, and a
disk that fills up leaves a file without a summary, which most readers refuse. Here everything that belongs together is
appended in one go; if that fails, the file is cut back to where it was, and :meth:`McapFile.finish` still closes it.
The records themselves are the library's (https://mcap.dev/spec).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Mapping
from typing import Protocol

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from dp_tools.recorder.compression import DEFAULT_COMPRESSION, compressor

_MAGIC = b"\x89MCAP0\r\n"
# Opcode, length of the rest, channel, sequence, log time, publish time; the message follows.
_MESSAGE_HEAD = struct.Struct("<BQHIQQ")
_MESSAGE_REST = _MESSAGE_HEAD.size - 9
# Bytes of a chunk index without its channels, and for each of them.
_CHUNK_INDEX_SIZE = 80
_CHUNK_INDEX_CHANNEL_SIZE = 10
# Statistics, summary offsets, footer and what else every summary has.
_SUMMARY_REST = 1024


class Stream(Protocol):
    """What is written to: an unbuffered binary file opened for writing."""

    def write(self, data: memoryview, /) -> int | None:
        """Write some of ``data`` and return how much."""

    def seek(self, offset: int, /) -> int:
        """Go to ``offset``."""

    def truncate(self, size: int, /) -> int:
        """Cut the file to ``size``."""

    def close(self) -> None:
        """Close the file."""


def _encode(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    encoded: bytes = builder.end()
    return encoded


class _OpenChunk:
    """Records on their way into the next chunk."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0
        self.index: dict[int, list[tuple[int, int]]] = {}
        self.start = 0
        self.end = 0

    def add(self, part: bytes) -> None:
        self.parts.append(part)
        self.size += len(part)


class McapFile:
    """Writes one MCAP file with compressed chunks, and all indexes.

    Parameters
    ----------
    stream
        Empty, unbuffered binary file.
    library
        Name of the writing program, kept in the file.
    chunk_size
        Bytes, before compression, after which a chunk is written.
    compression
        Of the chunks: zstd, lz4 or none.

    Raises
    ------
    RecordingRefusedError
        If the compression is unknown.
    OSError
        From every method that writes, if the stream does. What that call was to write is then not in the file; all
        earlier data is, and the file can still be finished.
    """

    def __init__(
        self, stream: Stream, library: str, chunk_size: int = 1 << 20, compression: str = DEFAULT_COMPRESSION
    ) -> None:
        self._stream = stream
        self._chunk_size = chunk_size
        self._compression, self._compress = compressor(compression)
        self._chunk = _OpenChunk()
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunk_indexes: list[ChunkIndex] = []
        self._attachment_indexes: list[AttachmentIndex] = []
        self._metadata_indexes: list[MetadataIndex] = []
        self._written: dict[int, int] = {}
        self._start = 0
        self._end = 0
        self._pending = 0
        self._crc = 0  # of all that is in the file
        self.size = 0
        """Bytes in the file."""
        self.summary_size = _SUMMARY_REST
        """Bytes that the summary takes, at most."""
        self._append(_MAGIC + _encode([Header(profile="ros2", library=library)]))

    @property
    def message_counts(self) -> Mapping[int, int]:
        """Messages in the file, by channel; those of the open chunk are not in it yet."""
        return self._written

    @property
    def pending(self) -> int:
        """Messages in the open chunk."""
        return self._pending

    @property
    def open_size(self) -> int:
        """Bytes in the open chunk, before compression."""
        return self._chunk.size

    @property
    def time_span(self) -> tuple[int, int]:
        """Smallest and largest log time in the file, ns; zeros without a message."""
        return self._start, self._end

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema and return its id."""
        schema_id = len(self._schemas) + 1
        schema = Schema(id=schema_id, name=name, encoding=encoding, data=data)
        self._schemas.append(schema)
        self._define(schema)
        return schema_id

    def add_channel(self, topic: str, schema_id: int, encoding: str, metadata: dict[str, str]) -> int:
        """Add a channel and return its id."""
        channel_id = len(self._channels) + 1
        channel = Channel(id=channel_id, topic=topic, message_encoding=encoding, metadata=metadata, schema_id=schema_id)
        self._channels.append(channel)
        self._define(channel)
        return channel_id

    def _define(self, record: McapRecord) -> None:
        encoded = _encode([record])
        self._chunk.add(encoded)
        self.summary_size += len(encoded)

    def add_message(self, channel_id: int, sequence: int, log_time: int, publish_time: int, data: bytes) -> None:
        """Add a message; times in ns. It is in the file once its chunk is full or ended."""
        chunk = self._chunk
        entries = chunk.index.get(channel_id)
        if entries is None:
            entries = chunk.index[channel_id] = []
        entries.append((log_time, chunk.size))
        if self._pending == 0:
            chunk.start = chunk.end = log_time
        elif log_time > chunk.end:
            chunk.end = log_time
        elif log_time < chunk.start:
            chunk.start = log_time
        self._pending += 1
        length = len(data) + _MESSAGE_REST
        chunk.parts.append(
            _MESSAGE_HEAD.pack(Opcode.MESSAGE, length, channel_id, sequence & 0xFFFFFFFF, log_time, publish_time)
        )
        chunk.parts.append(data)
        chunk.size += 9 + length
        if chunk.size >= self._chunk_size:
            self.end_chunk()

    def end_chunk(self) -> None:
        """Write the open chunk, if it holds a message. If that fails, its messages are lost."""
        if self._pending == 0:
            return
        chunk = self._chunk
        self._chunk, self._pending = _OpenChunk(), 0
        raw = b"".join(chunk.parts)
        record = Chunk(
            compression=self._compression,
            data=self._compress(raw),
            message_start_time=chunk.start,
            message_end_time=chunk.end,
            uncompressed_crc=zlib.crc32(raw),
            uncompressed_size=len(raw),
        )
        builder = RecordBuilder()
        record.write(builder)
        chunk_length = builder.count
        offsets = {}
        for channel_id, entries in chunk.index.items():
            offsets[channel_id] = self.size + builder.count
            MessageIndex(channel_id=channel_id, records=entries).write(builder)
        index = ChunkIndex(
            message_start_time=chunk.start,
            message_end_time=chunk.end,
            chunk_start_offset=self.size,
            chunk_length=chunk_length,
            message_index_offsets=offsets,
            message_index_length=builder.count - chunk_length,
            compression=record.compression,
            compressed_size=len(record.data),
            uncompressed_size=record.uncompressed_size,
        )
        self._append(builder.end())
        self._start = min(self._start, chunk.start) if self._written else chunk.start
        self._end = max(self._end, chunk.end)
        for channel_id, entries in chunk.index.items():
            self._written[channel_id] = self._written.get(channel_id, 0) + len(entries)
        self._chunk_indexes.append(index)
        self.summary_size += _CHUNK_INDEX_SIZE + _CHUNK_INDEX_CHANNEL_SIZE * len(offsets)

    def add_attachment(
        self, name: str, media_type: str, data: bytes, time: int, create_time: int | None = None
    ) -> None:
        """Write an attachment; ``time`` is its log time, ns, and its time of creation if that is not given."""
        created = time if create_time is None else create_time
        encoded = _encode([Attachment(create_time=created, log_time=time, name=name, media_type=media_type, data=data)])
        index = AttachmentIndex(
            offset=self.size,
            length=len(encoded),
            create_time=created,
            log_time=time,
            data_size=len(data),
            name=name,
            media_type=media_type,
        )
        self._append(encoded)
        self._attachment_indexes.append(index)
        self.summary_size += _CHUNK_INDEX_SIZE + len(name) + len(media_type)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Write a metadata record."""
        encoded = _encode([Metadata(name=name, metadata=values)])
        index = MetadataIndex(offset=self.size, length=len(encoded), name=name)
        self._append(encoded)
        self._metadata_indexes.append(index)
        self.summary_size += _CHUNK_INDEX_SIZE + len(name)

    def finish(self) -> None:
        """Write the summary; end the open chunk first. The stream stays open."""
        data_end = _encode([DataEnd(data_section_crc=self._crc)])
        start = self.size + len(data_end)
        builder = RecordBuilder()
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, [*self._chunk_indexes]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachment_indexes]),
            (Opcode.METADATA_INDEX, [*self._metadata_indexes]),
        ]
        offsets = []
        for opcode, records in groups:
            group_start = builder.count
            for record in records:
                record.write(builder)
            if records:
                offsets.append(
                    SummaryOffset(
                        group_opcode=opcode, group_start=start + group_start, group_length=builder.count - group_start
                    )
                )
        offset_start = start + builder.count
        for offset in offsets:
            offset.write(builder)
        summary = builder.end()
        # The checksum covers the summary and the footer up to the checksum itself.
        footer_head = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start)
        footer = Footer(
            summary_start=start,
            summary_offset_start=offset_start,
            summary_crc=zlib.crc32(footer_head, zlib.crc32(summary)),
        )
        self._append(data_end + summary + _encode([footer]) + _MAGIC)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachment_indexes),
            channel_count=len(self._channels),
            channel_message_counts=dict(self._written),
            chunk_count=len(self._chunk_indexes),
            message_count=sum(self._written.values()),
            message_start_time=self._start,
            message_end_time=self._end,
            metadata_count=len(self._metadata_indexes),
            schema_count=len(self._schemas),
        )

    def _append(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._stream.write(rest) or 0 :]
        except OSError:
            self._stream.seek(self.size)
            self._stream.truncate(self.size)
            raise
        self.size += len(data)
        self._crc = zlib.crc32(data, self._crc)
