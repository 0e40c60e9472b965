"""A bag: a folder with one MCAP file or several, and metadata.yaml."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from dp_tools.recorder import STOPPED_WORDS
from dp_tools.recorder.bag_metadata import FileInfo, TopicInfo, bag_metadata, to_yaml
from dp_tools.recorder.compression import DEFAULT_COMPRESSION
from dp_tools.recorder.errors import RecordingRefusedError, RecordingStoppedError
from dp_tools.recorder.mcap_file import McapFile, Stream

METADATA = "metadata.yaml"
# A recorder that was killed leaves it behind.
RESERVE = ".reserve"
# Kept free for summary and metadata, so that a bag can be closed on a full disk. It grows with the summary.
RESERVE_BYTES = 1 << 20
# metadata.yaml, and its copy in the MCAP file, with many publishers of a topic.
_TOPIC_BYTES = 8192
# A file is as large as it was to be once less than this share of it is left.
_ROOM_SHARE = 16


@dataclass(frozen=True, slots=True)
class Limits:
    """When a bag goes on in another file; 0 for never.

    Attributes
    ----------
    size
        Bytes of a file, without its summary.
    duration
        Nanoseconds of log time in a file.
    """

    size: int = 0
    duration: int = 0


@dataclass(slots=True)
class _Repeated:
    """An attachment that every file has."""

    media_type: str
    data: bytes
    time: int


def _nothing_fresh() -> Mapping[str, bytes]:
    return {}


class BagWriter:
    """Writes messages of any type to a new bag.

    Every file of the bag is complete by itself: it has all channels, records and attachments. What a further file
    repeats of them has a log time after its time of creation.

    Parameters
    ----------
    folder
        Of the bag; made here. Its name is that of the MCAP files.
    overwrite
        True to replace a bag that is there. Nothing but a bag is ever replaced.
    chunk_size
        Bytes of a chunk before compression.
    open_stream
        Opens an MCAP file for writing, unbuffered.
    compression
        Of chunks: zstd, lz4 or none.
    limits
        When to go on in another file.

    Attributes
    ----------
    fresh
        Returns attachments by name whose content has changed since they were attached; asked when a file begins.

    Raises
    ------
    RecordingRefusedError
        If the folder holds something already, cannot be written, or the disk has no room to close a bag.
    """

    def __init__(
        self,
        folder: Path,
        overwrite: bool = False,
        chunk_size: int = 1 << 20,
        open_stream: Callable[[Path], Stream] | None = None,
        compression: str = DEFAULT_COMPRESSION,
        limits: Limits | None = None,
    ) -> None:
        self.folder = folder
        self.fresh: Callable[[], Mapping[str, bytes]] = _nothing_fresh
        self._reserve = folder / RESERVE
        self._reserved = 0
        self._open_stream = open_stream or _open
        self._chunk_size = chunk_size
        self._compression = compression
        self._limits = limits or Limits()
        self._limited = self._limits != Limits()
        self._schemas: dict[str, str] = {}
        self._topics: list[TopicInfo] = []
        self._attachments: dict[str, _Repeated] = {}
        self._records: dict[str, dict[str, str]] = {}
        self._finished: list[FileInfo] = []
        self._finished_bytes = 0
        self._counts: dict[int, int] = {}  # of finished files, by channel
        self._begun = 0  # log time of the first message of the file
        self._failed: RecordingStoppedError | None = None
        self._cause: OSError | None = None
        _clear(folder, overwrite)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._keep_free(RESERVE_BYTES)
            self._begin_file()
        except OSError as error:
            self._give_up()
            raise RecordingRefusedError(f"{folder}: cannot be written: {error.strerror or error}") from error
        except RecordingRefusedError:
            self._give_up()
            raise

    @property
    def path(self) -> Path:
        """The MCAP file that is being written."""
        return self._path

    @property
    def file_count(self) -> int:
        """Files of the bag so far."""
        return len(self._finished) + (not self._closed)

    @property
    def size(self) -> int:
        """Bytes in all MCAP files."""
        return self._finished_bytes + (0 if self._closed else self._file.size)

    @property
    def message_count(self) -> int:
        """Messages written, those of the open chunk included."""
        return self._written() + (0 if self._closed else self._file.pending)

    @property
    def failed(self) -> RecordingStoppedError | None:
        """Why the recording stopped; None while it has not."""
        return self._failed

    @property
    def disk_full(self) -> bool:
        """Whether it stopped because no room was left."""
        return self._cause is not None and self._cause.errno in (errno.ENOSPC, errno.EDQUOT)

    def add_topic(self, topic: TopicInfo, definition: str) -> int:
        """Add a topic with its full message definition and return its channel."""
        self._schemas.setdefault(topic.kind, definition)
        self._topics.append(topic)
        return self._define(topic)

    def _define(self, topic: TopicInfo) -> int:
        schema_id = self._schema_ids.get(topic.kind)
        if schema_id is None:
            schema_id = self._file.add_schema(topic.kind, "ros2msg", self._schemas[topic.kind].encode())
            self._schema_ids[topic.kind] = schema_id
        metadata = {"offered_qos_profiles": topic.quality_text(), "topic_type_hash": topic.type_hash}
        return self._file.add_channel(topic.name, schema_id, "cdr", metadata)

    def write(self, channel: int, data: bytes, log_time: int, publish_time: int, sequence: int = 0) -> None:
        """Write one serialized message; times in ns.

        Raises
        ------
        RecordingStoppedError
            If the disk is full or fails. Close the bag then: what was written before is whole.
        """
        if self._failed is not None:
            raise self._failed
        if self._limited:
            self._split_if_due(len(data), log_time)
        before = self._file.pending
        try:
            self._file.add_message(channel, sequence, log_time, publish_time, data)
        except OSError as error:
            raise self._stopped(error, before + 1) from error

    def flush(self) -> None:
        """Write what is held back, so that it survives a crash of this process. Raises RecordingStoppedError."""
        if self._failed is not None:
            raise self._failed
        self._end_chunk(0)

    def _end_chunk(self, coming: int) -> None:
        """Write the open chunk, before so many messages to come, which are lost with it."""
        before = self._file.pending
        try:
            self._file.end_chunk()
            self._keep_free(self._file.summary_size + _TOPIC_BYTES * len(self._topics) + RESERVE_BYTES // 2)
        except OSError as error:
            raise self._stopped(error, before - self._file.pending + coming) from error

    def attach(self, name: str, media_type: str, data: bytes, time: int) -> None:
        """Attach a file; ``time`` in ns. Of several with one name, further files repeat the last.

        Raises
        ------
        RecordingStoppedError
            If it cannot be written.
        """
        if self._failed is not None:
            raise self._failed
        self._attachments[name] = _Repeated(media_type, data, time)
        try:
            self._file.add_attachment(name, media_type, data, time)
        except OSError as error:
            raise self._stopped(error, 0) from error

    def describe(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of words by name, e.g. of versions. Raises RecordingStoppedError."""
        if self._failed is not None:
            raise self._failed
        self._records[name] = dict(values)
        try:
            self._file.add_metadata(name, dict(values))
        except OSError as error:
            raise self._stopped(error, 0) from error

    def close(self, custom_data: Mapping[str, str] | None = None) -> None:
        """Finish the MCAP file and write metadata.yaml.

        Raises
        ------
        RecordingStoppedError
            If the last messages cannot be written, or have not been earlier on: the bag is closed, without them. Or if
            even that is not possible: the message says so.
        """
        custom = dict(custom_data or {})
        if self._failed is None:
            with suppress(RecordingStoppedError):
                self.flush()
        self._reserve.unlink(missing_ok=True)
        if self._failed is not None:
            custom["stopped"] = str(self._failed)
        try:
            if not self._closed:
                self._finish_file(custom)
            information = bag_metadata(self._finished, self._topic_counts(self._counts), custom)
            temporary = self.folder / f"{METADATA}.tmp"
            temporary.write_text(to_yaml({"rosbag2_bagfile_information": information}), encoding="utf-8")
            temporary.replace(self.folder / METADATA)
        except OSError as error:
            raise RecordingStoppedError(
                f"{self.folder}: the bag could not be closed: {error.strerror or error}"
            ) from error
        if self._failed is not None:
            raise self._failed

    # Files -----------------------------------------------------------------------------------------------------------

    def _begin_file(self) -> None:
        """Open the next file, which has nothing but its header yet. Raises OSError."""
        self._closed = True
        self._path = self.folder / f"{self.folder.absolute().name}_{len(self._finished)}.mcap"
        self._schema_ids: dict[str, int] = {}
        self._stream = self._open_stream(self._path)
        try:
            self._file = McapFile(self._stream, "dp_tools recorder", self._chunk_size, self._compression)
        except BaseException:
            self._stream.close()
            self._path.unlink(missing_ok=True)
            raise
        self._closed = False

    def _split_if_due(self, length: int, log_time: int) -> None:
        """Go on in another file if the message to come does not fit in this one."""
        file, limits = self._file, self._limits
        if not file.pending and not file.message_counts:
            self._begun = log_time
            return  # the first message of a file is in it, whatever its size
        if limits.duration and log_time - self._begun >= limits.duration:
            self._split(log_time)
        elif limits.size and file.size + file.open_size + length > limits.size:
            self._end_chunk(1)  # what it takes is known once it is compressed
            if file.size + length > limits.size - limits.size // _ROOM_SHARE:
                self._split(log_time)

    def _split(self, log_time: int) -> None:
        """Finish the file and begin another with all that belongs to every file."""
        self._end_chunk(1)
        try:
            self._finish_file({})
            self._begin_file()
            self._begun = log_time
            for topic in self._topics:
                self._define(topic)
            fresh = self.fresh()
            for name, kept in self._attachments.items():
                data = fresh.get(name, kept.data)
                self._file.add_attachment(name, kept.media_type, data, max(log_time, kept.time + 1), kept.time)
            for name, values in self._records.items():
                self._file.add_metadata(name, values)
        except OSError as error:
            raise self._stopped(error, 1) from error

    def _finish_file(self, custom: Mapping[str, str]) -> None:
        """Write the summary, and note what is in the file. Raises OSError; it may be tried again."""
        file = self._file
        start, end = file.time_span
        counts = file.message_counts
        info = FileInfo(self._path.name, start, end, sum(counts.values()))
        alone = bag_metadata([info], self._topic_counts(counts), custom)
        file.add_metadata("rosbag2", {"serialized_metadata": to_yaml(alone)})
        file.finish()
        self._stream.close()
        self._closed = True
        self._finished.append(info)
        self._finished_bytes += file.size
        for channel, count in counts.items():
            self._counts[channel] = self._counts.get(channel, 0) + count

    def _topic_counts(self, counts: Mapping[int, int]) -> list[tuple[TopicInfo, int]]:
        # Channels are numbered from 1 in the order of their topics, in every file.
        return [(topic, counts.get(channel, 0)) for channel, topic in enumerate(self._topics, 1)]

    def _written(self) -> int:
        return sum(self._counts.values()) + (0 if self._closed else sum(self._file.message_counts.values()))

    # A disk that fills up --------------------------------------------------------------------------------------------

    def _keep_free(self, size: int) -> None:
        """Keep at least so many bytes of the disk for closing the bag. Raises OSError."""
        if size <= self._reserved:
            return
        size = -(-size // RESERVE_BYTES) * RESERVE_BYTES
        with self._reserve.open("ab") as reserve:
            os.posix_fallocate(reserve.fileno(), 0, size)
        self._reserved = size

    def _stopped(self, error: OSError, lost: int) -> RecordingStoppedError:
        self._cause = error
        self._failed = RecordingStoppedError(
            f"{self._path}: {STOPPED_WORDS}: {error.strerror or error}; {self._written()} "
            f"messages are in the bag, the last {lost} were not written"
        )
        return self._failed

    def _give_up(self) -> None:
        """Leave nothing behind of a bag that could not begin."""
        with suppress(OSError):
            self._reserve.unlink(missing_ok=True)
            self.folder.rmdir()


def _open(path: Path) -> Stream:
    # "x": a file that appeared meanwhile is not ours to replace.
    return path.open("xb", buffering=0)


def _clear(folder: Path, overwrite: bool) -> None:
    """Make way for a bag: the folder may be missing or empty; with ``overwrite`` it may hold a bag, which goes."""
    try:
        if not folder.exists():
            return
        if not folder.is_dir():
            raise RecordingRefusedError(f"{folder}: expected a folder for the bag, found a file")
        content = sorted(folder.iterdir())
        foreign = [path.name for path in content if not _belongs_to_a_bag(path)]
        if foreign:
            raise RecordingRefusedError(f"{folder}: expected a bag or nothing, found {', '.join(foreign[:5])}")
        if content and not overwrite:
            raise RecordingRefusedError(f"{folder}: holds a recording, which is not overwritten unless asked for")
        for path in content:
            path.unlink()
    except OSError as error:
        raise RecordingRefusedError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _belongs_to_a_bag(path: Path) -> bool:
    known = path.name in (METADATA, f"{METADATA}.tmp", RESERVE) or path.suffix == ".mcap"
    return known and path.is_file()
