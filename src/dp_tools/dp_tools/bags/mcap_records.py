"""Records of an MCAP file, one by one, however damaged the file is.

The mcap library parses the records; here is what it leaves open: lengths are held against the file before anything is
read or unpacked, and whatever a parser raises becomes a DamageError.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import IO, Any

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
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
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from dp_tools.bags.errors import CutOffError, DamageError

MAGIC = b"\x89MCAP0\r\n"
# Opcode and length of the content.
RECORD_HEAD = struct.Struct("<BQ")
# Channel, sequence, log time, publish time; the data follows.
MESSAGE_HEAD = struct.Struct("<HIQQ")
# Records of this kind and above belong to the user; readers leave them out.
FIRST_PRIVATE = 0x80
# A chunk that claims to be larger than this is not unpacked: ours are 1 MiB, other writers' some MiB.
LARGEST_CHUNK = 1 << 31

_KINDS: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.MESSAGE: Message,
    Opcode.CHUNK: Chunk,
    Opcode.MESSAGE_INDEX: MessageIndex,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
    Opcode.DATA_END: DataEnd,
}
_NAMES: dict[int, str] = {int(opcode): opcode.name.lower().replace("_", " ") for opcode in Opcode}


@dataclass(frozen=True, slots=True)
class RawRecord:
    """A record as it is in the file.

    Attributes
    ----------
    opcode
        What it is.
    start
        Where it begins, at the opcode.
    content
        What follows opcode and length.
    """

    opcode: int
    start: int
    content: bytes

    @property
    def end(self) -> int:
        """Where the next one begins."""
        return self.start + RECORD_HEAD.size + len(self.content)


def record_name(opcode: int) -> str:
    """Return the name of a kind of record."""
    return _NAMES.get(opcode, f"record of kind {opcode}")


def raw_records(stream: IO[bytes], size: int, start: int = len(MAGIC)) -> Iterator[RawRecord]:
    """Yield the records of a file of ``size`` bytes from ``start`` to the footer, which comes last.

    Raises
    ------
    CutOffError
        If the file ends before its footer does.
    DamageError
        If a record is of no kind.
    OSError
        If it cannot be read.
    """
    at = start
    while True:
        stream.seek(at)
        head = stream.read(RECORD_HEAD.size)
        if len(head) < RECORD_HEAD.size:
            what = "in the middle of a record" if head else "without a footer"
            raise CutOffError(at, f"the file ends {what}")
        opcode, length = RECORD_HEAD.unpack(head)
        if opcode == 0:
            raise DamageError(at, "expected a record, found kind 0")
        if length > size - at - RECORD_HEAD.size:
            raise CutOffError(
                at, f"{record_name(opcode)} of {length} bytes, the file ends after {size - at - RECORD_HEAD.size}"
            )
        content = stream.read(length)
        if len(content) < length:
            raise CutOffError(at, f"{record_name(opcode)} of {length} bytes, only {len(content)} can be read")
        yield RawRecord(opcode, at, content)
        if opcode == Opcode.FOOTER:
            return
        at += RECORD_HEAD.size + length


def parsed(raw: RawRecord) -> Any:
    """Return a record as the library's object, whole and exactly as written.

    Raises
    ------
    DamageError
        If its content is not that of its kind, or the checksum of an attachment is wrong.
    """
    kind = _KINDS.get(raw.opcode)
    if kind is None:
        raise DamageError(raw.start, f"{record_name(raw.opcode)} is unknown")
    stream = ReadDataStream(BytesIO(raw.content))
    try:
        record = kind.read(stream, len(raw.content)) if kind is Message else kind.read(stream)
        again = _encoded(record)
    except (McapError, struct.error, ValueError, OverflowError, MemoryError) as error:
        raise DamageError(raw.start, f"{record_name(raw.opcode)} cannot be read: {_words(error)}") from error
    # A reader takes what it gets where a length inside is too large, and leaves what it does not know at the end, which
    # later versions of the format may add; of this one nothing is left and nothing lacks.
    found = raw.content
    if again != found and not _without_checksum(record, again, found):
        raise DamageError(raw.start, f"{record_name(raw.opcode)} {_why_different(record, again, found)}")
    return record


def _encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end()[RECORD_HEAD.size :])


def _without_checksum(record: Any, again: bytes, found: bytes) -> bool:
    """Return whether an attachment is what it should be, and holds 0 instead of a checksum, which is allowed."""
    return isinstance(record, Attachment) and found[:-4] == again[:-4] and found[-4:] == bytes(4)


def _why_different(record: Any, again: bytes, found: bytes) -> str:
    if isinstance(record, Attachment) and found[: len(again) - 4] == again[:-4]:
        return f"{record.name}: wrong checksum"
    return "has lengths that do not agree"


def _words(error: Exception) -> str:
    return str(error).replace("\n", " ") or type(error).__name__


def unpacked(chunk: Chunk, at: int) -> bytes:
    """Return what is in a chunk that begins at byte ``at`` of the file.

    Raises
    ------
    DamageError
        If it cannot be decompressed, is not as long as it says, or its checksum is wrong.
    """
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK:
        raise DamageError(at, f"chunk of {size} bytes, expected at most {LARGEST_CHUNK}")
    try:
        data = _decompressed(chunk, size, at)
    except (zstandard.ZstdError, RuntimeError, EOFError, ValueError, MemoryError) as error:
        raise DamageError(at, f"chunk cannot be decompressed ({chunk.compression}): {_words(error)}") from error
    if len(data) != size:
        raise DamageError(at, f"chunk: expected {size} bytes, found {len(data)}")
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise DamageError(at, "chunk: wrong checksum")
    return data


def _decompressed(chunk: Chunk, size: int, at: int) -> bytes:
    if chunk.compression == "zstd":
        # The frame may tell its size, which is what memory is taken for.
        told = zstandard.frame_content_size(chunk.data)
        if told not in (-1, size):
            raise DamageError(at, f"chunk: expected {size} bytes, compressed are {told}")
        return bytes(zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size))
    if chunk.compression == "lz4":
        decompressor = lz4.frame.LZ4FrameDecompressor()
        return bytes(decompressor.decompress(chunk.data, max_length=size + 1))
    if chunk.compression == "":
        return bytes(chunk.data)
    raise DamageError(at, f"chunk: expected compression zstd, lz4 or none, found '{chunk.compression[:20]}'")


def records_in(data: bytes, at: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of the content of every record in an unpacked chunk.

    Raises
    ------
    DamageError
        If the chunk, which begins at byte ``at`` of the file, ends in the middle of a record.
    """
    place, size, unpack, head = 0, len(data), RECORD_HEAD.unpack_from, RECORD_HEAD.size
    while place < size:
        if place + head > size:
            raise DamageError(at, "chunk ends in the middle of a record")
        opcode, length = unpack(data, place)
        begin = place + head
        place = begin + length
        if place > size or (opcode == Opcode.MESSAGE and length < MESSAGE_HEAD.size):
            raise DamageError(at, f"chunk: {record_name(opcode)} of {length} bytes at byte {begin - head} of {size}")
        yield opcode, begin, place
