"""The MCAP file: what is written is read back by the library, and a failing disk leaves a whole file."""

from __future__ import annotations

import errno
from io import BytesIO

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import DataEnd
from mcap.stream_reader import CRCValidationError, StreamReader

from dp_tools.recorder.mcap_file import McapFile


class Disk(BytesIO):
    """A file on a disk with so much room; once full, what was cut off may be written again."""

    def __init__(self, room: int = 1 << 30, at_most: int = 1 << 30) -> None:
        super().__init__()
        self.room = room
        self.at_most = at_most

    def write(self, data: memoryview) -> int:  # type: ignore[override]
        count = min(len(data), self.room - self.tell(), self.at_most)
        if count <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data[:count])


Sent = list[tuple[int, int, int, int, bytes]]


def fill(file: McapFile, messages: Sent) -> list[int]:
    """Add two channels and messages, numbered by channel 0 or 1."""
    schema = file.add_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channels = [
        file.add_channel(topic, schema, "cdr", {"offered_qos_profiles": "", "topic_type_hash": "RIHS01_0"})
        for topic in ("/a", "/b")
    ]
    for which, sequence, log_time, publish_time, data in messages:
        file.add_message(channels[which], sequence, log_time, publish_time, data)
    return channels


def read(disk: BytesIO) -> Sent:
    """Return the messages in the order of the file, checksums checked."""
    disk.seek(0)
    reader = make_reader(disk, validate_crcs=True)
    return [
        (("/a", "/b").index(channel.topic), message.sequence, message.log_time, message.publish_time, message.data)
        for _, channel, message in reader.iter_messages(log_time_order=False)
    ]


MESSAGES = st.lists(
    st.tuples(
        st.integers(0, 1),
        st.integers(0, 2**32 - 1),
        st.integers(0, 2**63 - 1),
        st.integers(0, 2**63 - 1),
        st.binary(max_size=300),
    ),
    max_size=60,
)


@given(MESSAGES, st.sampled_from([64, 1000, 1 << 20]))
def test_what_is_written_is_read_back(messages: Sent, chunk_size: int) -> None:
    disk = Disk()
    file = McapFile(disk, "test", chunk_size)
    fill(file, messages)
    file.end_chunk()
    file.finish()
    assert read(disk) == messages
    assert file.size == len(disk.getvalue())

    disk.seek(0)
    summary = make_reader(disk).get_summary()
    assert summary is not None
    statistics = summary.statistics
    assert statistics is not None
    assert statistics.message_count == len(messages)
    for channel in (1, 2):
        assert statistics.channel_message_counts.get(channel, 0) == sum(m[0] == channel - 1 for m in messages)
    if messages:
        assert statistics.message_start_time == min(m[2] for m in messages)
        assert statistics.message_end_time == max(m[2] for m in messages)
        assert {channel.topic for channel in summary.channels.values()} == {"/a", "/b"}
        assert [schema.name for schema in summary.schemas.values()] == ["std_msgs/msg/String"]


@given(MESSAGES)
def test_reading_in_time_order_uses_the_indexes(messages: Sent) -> None:
    disk = Disk()
    file = McapFile(disk, "test", 200)
    fill(file, messages)
    file.end_chunk()
    file.finish()
    disk.seek(0)
    times = [message.log_time for _, _, message in make_reader(disk).iter_messages(topics=["/b"])]
    assert times == sorted(m[2] for m in messages if m[0] == 1)


@settings(max_examples=200)
@given(MESSAGES, st.integers(100, 8000), st.sampled_from([7, 1 << 20]))
def test_a_disk_that_fills_up_anywhere_leaves_a_whole_file(messages: Sent, room: int, at_most: int) -> None:
    """Every message of a finished chunk is there, in order, and no other; and the file can be closed."""
    disk = Disk(room, at_most)
    file = McapFile(disk, "test", 400)
    stopped = False
    try:
        fill(file, messages)
        file.end_chunk()
    except OSError:
        stopped = True
    count = sum(file.message_counts.values())
    assert stopped or count == len(messages)
    assert len(disk.getvalue()) == file.size
    disk.room = 1 << 30  # the reserve is given back
    file.finish()
    assert read(disk) == messages[:count]
    # The checksum is that of what is there, not of what could not be written.
    disk.seek(0)
    (end,) = [r for r in StreamReader(disk, validate_crcs=True).records if isinstance(r, DataEnd)]
    assert end.data_section_crc != 0


def test_the_file_cannot_begin_on_a_full_disk() -> None:
    with pytest.raises(OSError, match="No space left"):
        McapFile(Disk(room=3), "test")


def test_attachments_and_metadata_are_found_again() -> None:
    disk = Disk()
    file = McapFile(disk, "test")
    file.add_attachment("vessel.yaml", "application/yaml", b"name: x", 17)
    fill(file, [(0, 1, 5, 4, b"1")])
    file.end_chunk()
    file.add_metadata("rosbag2", {"serialized_metadata": "version: 9"})
    file.finish()
    disk.seek(0)
    reader = make_reader(disk, validate_crcs=True)
    attachment = next(iter(reader.iter_attachments()))
    assert (attachment.name, attachment.media_type, attachment.data) == ("vessel.yaml", "application/yaml", b"name: x")
    assert attachment.log_time == 17
    metadata = next(iter(reader.iter_metadata()))
    assert (metadata.name, metadata.metadata) == ("rosbag2", {"serialized_metadata": "version: 9"})


def test_a_reader_that_does_not_seek_finds_the_same() -> None:
    disk = Disk()
    file = McapFile(disk, "test", 100)
    messages = [(i % 2, i, i, i, bytes([i]) * 20) for i in range(50)]
    fill(file, messages)
    file.end_chunk()
    file.finish()
    disk.seek(0)
    found = [r for r in StreamReader(disk, validate_crcs=True).records if type(r).__name__ == "Message"]
    assert [(m.sequence, m.data) for m in found] == [(m[1], m[4]) for m in messages]


def test_every_byte_of_the_data_is_under_a_checksum() -> None:
    """Also what has none of its own: a changed letter in a metadata record."""
    disk = Disk()
    file = McapFile(disk, "test", 100)
    fill(file, [(i % 2, i, i, i, bytes([i]) * 20) for i in range(20)])
    file.end_chunk()
    file.add_metadata("rosbag2", {"serialized_metadata": "version: 9"})
    file.finish()
    disk.seek(0)
    (end,) = [r for r in StreamReader(disk, validate_crcs=True).records if isinstance(r, DataEnd)]
    assert end.data_section_crc != 0  # which would mean that there is none
    changed = disk.getvalue().replace(b"version: 9", b"version: 8")
    with pytest.raises(CRCValidationError, match="DataEnd"):
        list(StreamReader(BytesIO(changed), validate_crcs=True).records)


def test_library_and_profile_are_said() -> None:
    disk = Disk()
    McapFile(disk, "the recorder").finish()
    disk.seek(0)
    header = make_reader(disk).get_header()
    assert (header.profile, header.library) == ("ros2", "the recorder")
