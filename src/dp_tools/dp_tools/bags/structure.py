"""Structure of one MCAP file: every record, checksum, count and index against what is there."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, ChunkIndex, MetadataIndex, SummaryOffset

from dp_tools.bags.errors import CutOffError, DamageError
from dp_tools.bags.finding import Finding
from dp_tools.bags.mcap_records import (
    FIRST_PRIVATE,
    MAGIC,
    MESSAGE_HEAD,
    RECORD_HEAD,
    RawRecord,
    parsed,
    raw_records,
    record_name,
    records_in,
    unpacked,
)

# A checksum covers the footer up to the checksum itself.
_FOOTER_HEAD = RECORD_HEAD.size + 16


@dataclass
class Contents:
    """What is in the data section of a file.

    Attributes
    ----------
    messages
        Number by channel.
    span
        Smallest and largest log time, ns; None without a message.
    finished
        Whether the file ends as it should.
    """

    messages: Counter[int] = field(default_factory=Counter)
    span: tuple[int, int] | None = None
    schemas: dict[int, Any] = field(default_factory=dict)
    channels: dict[int, Any] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    words: dict[str, dict[str, str]] = field(default_factory=dict)
    finished: bool = False

    def note_message(self, channel: int, log_time: int) -> None:
        """Count a message."""
        self.messages[channel] += 1
        first, last = self.span or (log_time, log_time)
        self.span = min(first, log_time), max(last, log_time)


class _Chunk:
    """A chunk whose indexes follow."""

    def __init__(self, raw: RawRecord, record: Any) -> None:
        self.raw = raw
        self.record = record
        self.entries: dict[int, list[tuple[int, int]]] = {}
        self.index_offsets: dict[int, int] = {}
        self.end = raw.end

    def as_index(self) -> ChunkIndex:
        """Return what the summary should say of it."""
        return ChunkIndex(
            message_start_time=self.record.message_start_time,
            message_end_time=self.record.message_end_time,
            chunk_start_offset=self.raw.start,
            chunk_length=self.raw.end - self.raw.start,
            message_index_offsets=self.index_offsets,
            message_index_length=self.end - self.raw.end,
            compression=self.record.compression,
            compressed_size=len(self.record.data),
            uncompressed_size=self.record.uncompressed_size,
        )


class StructureCheck:
    """Checks one file; :attr:`findings` and :attr:`contents` are the outcome.

    Parameters
    ----------
    path
        The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.findings: list[Finding] = []
        self.contents = Contents()
        self._chunk: _Chunk | None = None
        self._in_summary = False
        self._summary: list[tuple[RawRecord, Any]] = []
        self._crc = 0

    def run(self, progress: Callable[[int], None] = lambda done: None) -> None:
        """Read the whole file. ``progress`` is called with the bytes read so far. Raises OSError."""
        with self._path.open("rb") as stream:
            size = self._path.stat().st_size
            magic = stream.read(len(MAGIC))
            if magic != MAGIC:
                short = len(magic) < len(MAGIC) and MAGIC.startswith(magic)
                self._wrong(0, "the file ends within its first bytes" if short else "not an MCAP file")
                return
            self._crc = zlib.crc32(MAGIC)
            end = self._records(stream, size, progress)
            self._end_chunk()
            if end is None:
                count = sum(self.contents.messages.values())
                self._say(
                    f"unfinished: its recorder was killed, or the file was cut; {count} messages are whole before that"
                )
                return
            stream.seek(end)
            rest = stream.read(len(MAGIC) + 1)
            if rest != MAGIC:
                cut = len(rest) < len(MAGIC) and MAGIC.startswith(rest)
                what = "the file ends within its last bytes" if cut else "expected the end of the file, found more"
                self._wrong(end, what)
            if not self._in_summary:
                self._wrong(end, "no end of the data before the footer")
            self._check_summary(stream, end)
            self.contents.finished = rest == MAGIC

    # Data section -----------------------------------------------------------------------------------------------------

    def _records(self, stream: IO[bytes], size: int, progress: Callable[[int], None]) -> int | None:
        """Look at every record; return where the footer ends, None if there is none."""
        first, at = True, len(MAGIC)
        try:
            for raw in raw_records(stream, size):
                if first and raw.opcode != Opcode.HEADER:
                    self._wrong(raw.start, f"expected the header, found {record_name(raw.opcode)}")
                first, at = False, raw.end
                try:
                    self._look_at(raw)
                except DamageError as error:
                    self._wrong(error.at, error.reason)
                if not self._in_summary:
                    self._crc = _record_crc(raw, self._crc)
                if raw.opcode == Opcode.CHUNK:
                    progress(raw.end)
        except CutOffError as error:
            self._wrong(error.at, error.reason)
            return None
        except DamageError as error:
            self._wrong(error.at, error.reason)
            return None
        return at

    def _look_at(self, raw: RawRecord) -> None:
        if raw.opcode >= FIRST_PRIVATE:
            return
        if raw.opcode != Opcode.MESSAGE_INDEX:
            self._end_chunk()
        record = parsed(raw)
        if self._in_summary:
            self._summary.append((raw, record))
            return
        contents, length = self.contents, raw.end - raw.start
        if raw.opcode == Opcode.CHUNK:
            self._take_chunk(raw, record)
        elif raw.opcode == Opcode.MESSAGE_INDEX:
            self._take_message_index(raw, record)
        elif raw.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            self._define(raw.opcode, record, raw.start)
        elif raw.opcode == Opcode.MESSAGE:
            self._note(record.channel_id, record.log_time, raw.start)
        elif raw.opcode == Opcode.ATTACHMENT:
            contents.attachments.append(
                AttachmentIndex(
                    offset=raw.start,
                    length=length,
                    create_time=record.create_time,
                    log_time=record.log_time,
                    data_size=len(record.data),
                    name=record.name,
                    media_type=record.media_type,
                )
            )
        elif raw.opcode == Opcode.METADATA:
            contents.metadata.append(MetadataIndex(offset=raw.start, length=length, name=record.name))
            contents.words[record.name] = record.metadata
        elif raw.opcode == Opcode.DATA_END:
            if record.data_section_crc not in (0, self._crc):
                self._wrong(raw.start, "wrong checksum of the data")
            self._in_summary = True
        elif raw.opcode != Opcode.HEADER and raw.opcode != Opcode.FOOTER:
            self._wrong(raw.start, f"{record_name(raw.opcode)} among the data")

    def _take_chunk(self, raw: RawRecord, record: Any) -> None:
        chunk = _Chunk(raw, record)
        self._chunk = chunk
        data = unpacked(record, raw.start)
        times: list[int] = []
        for opcode, begin, end in records_in(data, raw.start):
            if opcode == Opcode.MESSAGE:
                channel, _, log_time, _ = MESSAGE_HEAD.unpack_from(data, begin)
                self._note(channel, log_time, raw.start)
                chunk.entries.setdefault(channel, []).append((log_time, begin - RECORD_HEAD.size))
                times.append(log_time)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._define(opcode, parsed(RawRecord(opcode, raw.start, data[begin:end])), raw.start)
            elif opcode < FIRST_PRIVATE:
                self._wrong(raw.start, f"chunk holds a {record_name(opcode)}")
        told = record.message_start_time, record.message_end_time
        if told != (min(times, default=0), max(times, default=0)):
            self._wrong(raw.start, "chunk: its messages are of another time than it says")

    def _note(self, channel: int, log_time: int, at: int) -> None:
        if channel not in self.contents.channels:
            self._wrong(at, f"message of channel {channel}, which is not defined before")
        self.contents.note_message(channel, log_time)

    def _define(self, opcode: int, record: Any, at: int) -> None:
        known = self.contents.schemas if opcode == Opcode.SCHEMA else self.contents.channels
        if known.setdefault(record.id, record) != record:
            self._wrong(at, f"{record_name(opcode)} {record.id} is defined in two ways")
        if opcode == Opcode.CHANNEL and record.schema_id not in {0, *self.contents.schemas}:
            self._wrong(at, f"channel {record.id} ({record.topic}): its schema {record.schema_id} is not there")

    def _take_message_index(self, raw: RawRecord, record: Any) -> None:
        chunk = self._chunk
        if chunk is None:
            self._wrong(raw.start, "message index that follows no chunk")
            return
        chunk.end = raw.end
        chunk.index_offsets[record.channel_id] = raw.start
        if sorted(record.records) != sorted(chunk.entries.get(record.channel_id, [])):
            self._wrong(raw.start, f"message index of channel {record.channel_id} is not that of the chunk before")

    def _end_chunk(self) -> None:
        chunk, self._chunk = self._chunk, None
        if chunk is None:
            return
        missing = sorted(chunk.entries.keys() - chunk.index_offsets.keys())
        if missing and chunk.index_offsets:
            self._wrong(chunk.raw.start, f"chunk without message index of channels {missing}")
        self.contents.chunks.append(chunk.as_index())

    # Summary ----------------------------------------------------------------------------------------------------------

    def _check_summary(self, stream: IO[bytes], end: int) -> None:
        if not self._summary or self._summary[-1][0].opcode != Opcode.FOOTER:
            self._wrong(end, "the footer cannot be read")
            return
        footer_raw, footer = self._summary[-1]
        records = self._summary[:-1]
        if footer.summary_start == 0:
            self._say("no summary: it is read from beginning to end", wrong=bool(records))
            return
        first = records[0][0].start if records else footer_raw.start
        if footer.summary_start != first:
            self._wrong(footer_raw.start, f"footer: summary at byte {footer.summary_start}, found at {first}")
            return
        if footer.summary_crc:
            stream.seek(first)
            covered = stream.read(footer_raw.start + _FOOTER_HEAD - first)
            if zlib.crc32(covered) != footer.summary_crc:
                self._wrong(first, "wrong checksum of the summary")
        self._compare(records)
        self._check_offsets(records, footer, footer_raw.start)

    def _compare(self, records: list[tuple[RawRecord, Any]]) -> None:
        contents = self.contents
        by_kind: dict[int, list[Any]] = {}
        for raw, record in records:
            by_kind.setdefault(raw.opcode, []).append(record)
        expected: list[tuple[int, list[Any]]] = [
            (Opcode.SCHEMA, [*contents.schemas.values()]),
            (Opcode.CHANNEL, [*contents.channels.values()]),
            (Opcode.CHUNK_INDEX, contents.chunks),
            (Opcode.ATTACHMENT_INDEX, contents.attachments),
            (Opcode.METADATA_INDEX, contents.metadata),
        ]
        for opcode, there in expected:
            told = by_kind.get(opcode, [])
            extra = [one for one in told if one not in there]
            # A schema or channel without a message may be in the summary alone, and a summary need not repeat them.
            defines = opcode in (Opcode.SCHEMA, Opcode.CHANNEL)
            used = {channel.id for channel in contents.channels.values() if contents.messages[channel.id]}
            if defines:
                known = contents.schemas if opcode == Opcode.SCHEMA else contents.channels
                extra = [one for one in extra if one.id in known]
            missing = [one for one in there if one not in told and (not defines or (told and one.id in used))]
            if extra or missing:
                name = record_name(opcode)
                self._say(f"summary: {name}: {len(extra)} that are not in the file, {len(missing)} missing")
        for statistics in by_kind.get(Opcode.STATISTICS, []):
            self._check_statistics(statistics)

    def _check_statistics(self, told: Any) -> None:
        contents = self.contents
        first, last = contents.span or (0, 0)
        counts: list[tuple[str, Any, Any]] = [
            ("messages", told.message_count, contents.messages.total()),
            ("messages by channel", +Counter(told.channel_message_counts), +contents.messages),
            ("first and last time", (told.message_start_time, told.message_end_time), (first, last)),
            ("chunks", told.chunk_count, len(contents.chunks)),
            ("attachments", told.attachment_count, len(contents.attachments)),
            ("metadata records", told.metadata_count, len(contents.metadata)),
        ]
        for what, says, there in counts:
            if says != there:
                self._say(f"summary: {what}: it says {_short(says)}, the file holds {_short(there)}")
        for what, says, there in (
            ("channels", told.channel_count, len(contents.channels)),
            ("schemas", told.schema_count, len(contents.schemas)),
        ):
            if says < there:  # those without a message are in the summary alone
                self._say(f"summary: {what}: it says {says}, the file holds {there}")

    def _check_offsets(self, records: list[tuple[RawRecord, Any]], footer: Any, at: int) -> None:
        groups: dict[int, list[int]] = {}
        offsets: list[tuple[int, SummaryOffset]] = []
        for raw, record in records:
            if isinstance(record, SummaryOffset):
                offsets.append((raw.start, record))
            else:
                span = groups.setdefault(raw.opcode, [raw.start, raw.end])
                span[1] = raw.end
        start = offsets[0][0] if offsets else 0
        if footer.summary_offset_start != start:
            self._wrong(at, f"footer: offsets of the summary at byte {footer.summary_offset_start}, found at {start}")
        for place, offset in offsets:
            # Of a group without records there may be an offset as well, to where it would be.
            begin, end = groups.get(offset.group_opcode, [offset.group_start] * 2)
            if (offset.group_start, offset.group_length) != (begin, end - begin):
                self._wrong(place, f"summary offset of {record_name(offset.group_opcode)}: not where it says")

    def _wrong(self, at: int, text: str) -> None:
        self.findings.append(Finding(self._path.name, f"byte {at}: {text}"))

    def _say(self, text: str, wrong: bool = True) -> None:
        self.findings.append(Finding(self._path.name, text, wrong))


def _record_crc(raw: RawRecord, before: int) -> int:
    return zlib.crc32(raw.content, zlib.crc32(RECORD_HEAD.pack(raw.opcode, len(raw.content)), before))


def _short(value: Any) -> str:
    text = str(dict(value)) if isinstance(value, Counter) else str(value)
    return text if len(text) < 80 else f"{text[:77]}..."
