"""A bag: a folder with one MCAP file and metadata.yaml."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

from dp_tools.recorder.bag_metadata import TopicInfo, bag_metadata, to_yaml
from dp_tools.recorder.errors import RecordingRefusedError, RecordingStoppedError
from dp_tools.recorder.mcap_file import McapFile, Stream

_METADATA = "metadata.yaml"
# Kept free for summary and metadata, so that a bag can be closed on a full disk. The summary grows by some hundred
# bytes a chunk of 1 MiB and by the message definitions: this is enough for a bag of a gigabyte.
RESERVE_BYTES = 1 << 20


class BagWriter:
    """Writes messages of any type to a new bag.

    Parameters
    ----------
    folder
        Of the bag; made here. Its name is that of the MCAP file.
    overwrite
        True to replace a bag that is there. Nothing but a bag is ever replaced.
    chunk_size
        Bytes of a chunk before compression.
    open_stream
        Opens the MCAP file for writing, unbuffered.

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
    ) -> None:
        self.folder = folder
        self._path = folder / f"{folder.absolute().name}_0.mcap"
        self._reserve = folder / ".reserve"
        self._topics: dict[int, TopicInfo] = {}
        self._schema_ids: dict[str, int] = {}
        self._failed: RecordingStoppedError | None = None
        _clear(folder, overwrite)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with self._reserve.open("wb") as reserve:
                os.posix_fallocate(reserve.fileno(), 0, RESERVE_BYTES)
            self._stream = (open_stream or _open)(self._path)
            self._file = McapFile(self._stream, "dp_tools recorder", chunk_size)
        except OSError as error:
            self._give_up()
            raise RecordingRefusedError(f"{folder}: cannot be written: {error.strerror or error}") from error

    @property
    def path(self) -> Path:
        """The MCAP file."""
        return self._path

    @property
    def size(self) -> int:
        """Bytes in the MCAP file."""
        return self._file.size

    @property
    def message_count(self) -> int:
        """Messages written, those of the open chunk included."""
        return sum(self._file.message_counts.values()) + self._file.pending

    def add_topic(self, topic: TopicInfo, definition: str) -> int:
        """Add a topic with its full message definition and return its channel."""
        schema_id = self._schema_ids.get(topic.kind)
        if schema_id is None:
            schema_id = self._file.add_schema(topic.kind, "ros2msg", definition.encode())
            self._schema_ids[topic.kind] = schema_id
        metadata = {"offered_qos_profiles": topic.quality_text(), "topic_type_hash": topic.type_hash}
        channel = self._file.add_channel(topic.name, schema_id, "cdr", metadata)
        self._topics[channel] = topic
        return channel

    def write(self, channel: int, data: bytes, log_time: int, publish_time: int, sequence: int = 0) -> None:
        """Write one serialized message; times in ns.

        Raises
        ------
        RecordingStoppedError
            If the disk is full or fails. Close the bag then: what was written before is whole.
        """
        if self._failed is not None:
            raise self._failed
        before = self._file.pending
        try:
            self._file.add_message(channel, sequence, log_time, publish_time, data)
        except OSError as error:
            raise self._stopped(error, before + 1) from error

    def flush(self) -> None:
        """Write what is held back, so that it survives a crash. Raises RecordingStoppedError."""
        if self._failed is not None:
            raise self._failed
        before = self._file.pending
        try:
            self._file.end_chunk()
        except OSError as error:
            raise self._stopped(error, before) from error

    def attach(self, name: str, media_type: str, data: bytes, time: int) -> None:
        """Attach a file; ``time`` in ns. Raises RecordingStoppedError."""
        try:
            self._file.add_attachment(name, media_type, data, time)
        except OSError as error:
            raise self._stopped(error, 0) from error

    def describe(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of words by name, e.g. of versions. Raises RecordingStoppedError."""
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
            try:
                self.flush()
            except RecordingStoppedError as stopped:
                self._failed = stopped
        self._remove_reserve()
        if self._failed is not None:
            custom["stopped"] = str(self._failed)
        counts = self._file.message_counts
        topics = [(topic, counts.get(channel, 0)) for channel, topic in self._topics.items()]
        information = bag_metadata(self._path.name, topics, self._file.time_span, custom)
        try:
            self._file.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information)})
            self._file.finish()
            self._stream.close()
            temporary = self.folder / f"{_METADATA}.tmp"
            temporary.write_text(to_yaml({"rosbag2_bagfile_information": information}), encoding="utf-8")
            temporary.replace(self.folder / _METADATA)
        except OSError as error:
            raise RecordingStoppedError(
                f"{self.folder}: the bag could not be closed: {error.strerror or error}"
            ) from error
        if self._failed is not None:
            raise self._failed

    def _stopped(self, error: OSError, lost: int) -> RecordingStoppedError:
        self._failed = RecordingStoppedError(
            f"{self._path}: recording stopped: {error.strerror or error}; {sum(self._file.message_counts.values())} "
            f"messages are in the bag, the last {lost} were not written"
        )
        return self._failed

    def _remove_reserve(self) -> None:
        self._reserve.unlink(missing_ok=True)

    def _give_up(self) -> None:
        """Leave nothing behind of a bag that could not begin."""
        with suppress(OSError):
            self._remove_reserve()
            self._path.unlink(missing_ok=True)
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
    known = path.name in (_METADATA, f"{_METADATA}.tmp", ".reserve") or path.suffix == ".mcap"
    return known and path.is_file()
