"""A bag as other tools see it, and what keeps one from being written."""

from __future__ import annotations

import errno
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import RESERVE_BYTES, BagWriter, Limits
from dp_tools.recorder.compression import COMPRESSIONS
from dp_tools.recorder.errors import RecordingRefusedError, RecordingStoppedError

STORE = get_typestore(Stores.ROS2_JAZZY)
KIND = "geometry_msgs/msg/Vector3Stamped"
DEFINITION, TYPE_HASH = STORE.generate_msgdef(KIND, ros_version=2)[0], STORE.hash_rihs01(KIND)
INFINITE = {"sec": 9223372036, "nsec": 854775807}
QUALITY: dict[str, Any] = {
    "history": "keep_last",
    "depth": 50,
    "reliability": "reliable",
    "durability": "transient_local",
    "deadline": INFINITE,
    "lifespan": INFINITE,
    "liveliness": "automatic",
    "liveliness_lease_duration": INFINITE,
    "avoid_ros_namespace_conventions": False,
}
TOPIC = TopicInfo("/vector", KIND, TYPE_HASH, (QUALITY,))


def message(k: int) -> bytes:
    types = STORE.types
    stamp = types["builtin_interfaces/msg/Time"](sec=k, nanosec=5)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="map_ned")
    vector = types["geometry_msgs/msg/Vector3"](x=float(k), y=-0.5, z=1e-300)
    return bytes(STORE.serialize_cdr(types[KIND](header=header, vector=vector), KIND))


def decoded(path: Path) -> list[Any]:
    """Return channel, message and decoded message, read by mcap and mcap-ros2-support, checksums checked."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [(channel, raw, ros) for _, channel, raw, ros in reader.iter_decoded_messages()]


def write_bag(folder: Path, count: int = 10) -> None:
    writer = BagWriter(folder)
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(count):
        writer.write(channel, message(k), 1000 + k, 900 + k, k)
    writer.close({"lost_messages": "0"})


def test_rosbags_opens_it(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == 10
        assert (reader.start_time, reader.end_time) == (1000, 1010)  # rosbags' end is one past the last
        (connection,) = reader.connections
        assert (connection.topic, connection.msgtype, connection.digest) == ("/vector", KIND, TYPE_HASH)
        quality: Any = connection.ext
        (offered,) = quality.offered_qos_profiles
        assert (offered.history, offered.depth) == (QosHistory.KEEP_LAST, 50)
        assert (offered.reliability, offered.durability) == (QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL)
        found: list[Any] = [(time, reader.deserialize(raw, connection.msgtype)) for _, time, raw in reader.messages()]
    assert [time for time, _ in found] == list(range(1000, 1010))
    assert [m.vector.x for _, m in found] == [float(k) for k in range(10)]
    assert {m.header.frame_id for _, m in found} == {"map_ned"}


def test_mcap_ros2_opens_it(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    found = decoded(tmp_path / "bag" / "bag_0.mcap")
    assert [ros.header.stamp.sec for _, _, ros in found] == list(range(10))
    assert [raw.log_time for _, raw, _ in found] == list(range(1000, 1010))
    assert [raw.publish_time for _, raw, _ in found] == list(range(900, 910))
    assert [raw.sequence for _, raw, _ in found] == list(range(10))
    assert {channel.topic for channel, _, _ in found} == {"/vector"}


def test_metadata_names_everything(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    assert sorted(path.name for path in (tmp_path / "bag").iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    information = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert information["message_count"] == 10
    assert information["duration"] == {"nanoseconds": 9}
    assert information["starting_time"] == {"nanoseconds_since_epoch": 1000}
    assert information["topics_with_message_count"][0]["topic_metadata"] == {
        "name": "/vector",
        "type": KIND,
        "serialization_format": "cdr",
        "offered_qos_profiles": [QUALITY],
        "type_description_hash": TYPE_HASH,
    }
    assert information["custom_data"] == {"lost_messages": "0"}


def test_a_bag_without_a_message_is_a_bag(tmp_path: Path) -> None:
    BagWriter(tmp_path / "bag").close()
    information = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == 0
    assert decoded(tmp_path / "bag" / "bag_0.mcap") == []


def test_a_bag_is_overwritten_only_if_asked_for(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    write_bag(folder)
    before = (folder / "bag_0.mcap").read_bytes()
    with pytest.raises(RecordingRefusedError, match="holds a recording, which is not overwritten unless asked for"):
        BagWriter(folder)
    assert (folder / "bag_0.mcap").read_bytes() == before
    BagWriter(folder, overwrite=True).close()
    assert decoded(folder / "bag_0.mcap") == []


def test_nothing_but_a_bag_is_ever_overwritten(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag")
    (tmp_path / "bag" / "notes.txt").write_text("keep me")
    with pytest.raises(RecordingRefusedError, match=r"expected a bag or nothing, found notes\.txt"):
        BagWriter(tmp_path / "bag", overwrite=True)
    assert (tmp_path / "bag" / "bag_0.mcap").exists()
    with pytest.raises(RecordingRefusedError, match="expected a folder for the bag, found a file"):
        BagWriter(tmp_path / "bag" / "notes.txt", overwrite=True)


def test_an_unwritable_place_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingRefusedError, match="cannot be written: Not a directory"):
        BagWriter(tmp_path / "file" / "bag")


def full(path: Path) -> Any:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_disk_full_from_the_start_is_refused_and_nothing_left_behind(tmp_path: Path) -> None:
    with pytest.raises(RecordingRefusedError, match=r"bag: cannot be written: No space left on device"):
        BagWriter(tmp_path / "bag", open_stream=full)
    assert list(tmp_path.iterdir()) == []


class SmallDisk:
    """A file on a disk that is full once the file has some size, for as long as the bag's reserve is not given back."""

    def __init__(self, path: Path, room: int, reserve: Path) -> None:
        self._file = path.open("xb", buffering=0)
        self._room = room
        self._reserve = reserve

    def write(self, data: memoryview) -> int:
        room = self._room + (0 if self._reserve.exists() else RESERVE_BYTES)
        count = min(len(data), room - self._file.tell())
        if count <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return self._file.write(data[:count])

    def seek(self, offset: int) -> int:
        return self._file.seek(offset)

    def truncate(self, size: int) -> int:
        return self._file.truncate(size)

    def close(self) -> None:
        self._file.close()


@pytest.mark.parametrize("room", [2000, 5000, 20_000])
def test_a_disk_that_fills_up_leaves_a_bag_that_every_tool_opens(tmp_path: Path, room: int) -> None:
    folder = tmp_path / "bag"
    writer = BagWriter(folder, chunk_size=2000, open_stream=lambda path: SmallDisk(path, room, folder / ".reserve"))
    channel = writer.add_topic(TOPIC, DEFINITION)
    written = 0

    def write_on() -> None:
        nonlocal written
        while written < 100_000:
            writer.write(channel, message(written), written, written, written)
            written += 1

    with pytest.raises(RecordingStoppedError, match="recording stopped: No space left on device"):
        write_on()
    with pytest.raises(RecordingStoppedError):
        writer.write(channel, message(0), 0, 0)
    with pytest.raises(RecordingStoppedError, match="No space left on device") as caught:
        writer.close()
    kept = writer.message_count
    assert f"{kept} messages are in the bag, the last {written + 1 - kept} were not written" in str(caught.value)
    assert not (folder / ".reserve").exists()

    assert [ros.header.stamp.sec for _, _, ros in decoded(folder / "bag_0.mcap")] == list(range(kept))
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["message_count"] == kept
    assert "No space left" in information["custom_data"]["stopped"]
    if kept:
        with AnyReader([folder]) as reader:
            assert reader.message_count == kept
            assert [time for _, time, _ in reader.messages()] == list(range(kept))


def test_a_disk_that_fills_up_at_the_last_moment_is_said_on_closing(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    writer = BagWriter(folder, open_stream=lambda path: SmallDisk(path, 100, folder / ".reserve"))
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(5):
        writer.write(channel, message(k), k, k)
    with pytest.raises(RecordingStoppedError, match="0 messages are in the bag, the last 5 were not written"):
        writer.close()
    assert decoded(folder / "bag_0.mcap") == []


def test_what_is_flushed_survives_without_closing(tmp_path: Path) -> None:
    """As after SIGKILL: there is no summary, but a reader that goes through the file finds the messages."""
    writer = BagWriter(tmp_path / "bag")
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(5):
        writer.write(channel, message(k), k, k)
    writer.flush()
    found: list[Any] = []
    records = StreamReader(BytesIO((tmp_path / "bag" / "bag_0.mcap").read_bytes()), validate_crcs=True).records
    with pytest.raises(EndOfFile):
        found.extend(record for record in records)
    assert [record.log_time for record in found if isinstance(record, Message)] == list(range(5))


# Compression and files -----------------------------------------------------------------------------------------------


def chunk_compressions(path: Path) -> set[str]:
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return {index.compression for index in summary.chunk_indexes}


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_every_compression_is_read_by_mcap_and_rosbags(tmp_path: Path, compression: str) -> None:
    writer = BagWriter(tmp_path / "bag", compression=compression, chunk_size=500)
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(50):
        writer.write(channel, message(k), 1000 + k, 900 + k, k)
    writer.close()
    path = tmp_path / "bag" / "bag_0.mcap"
    assert chunk_compressions(path) == {"" if compression == "none" else compression}
    assert [ros.header.stamp.sec for _, _, ros in decoded(path)] == list(range(50))
    with AnyReader([tmp_path / "bag"]) as reader:
        assert [time for _, time, _ in reader.messages()] == list(range(1000, 1050))


def test_an_unknown_compression_is_refused_and_nothing_left_behind(tmp_path: Path) -> None:
    with pytest.raises(RecordingRefusedError, match="compression: expected one of zstd, lz4, none, found 'zip'"):
        BagWriter(tmp_path / "bag", compression="zip")
    assert list(tmp_path.iterdir()) == []


def write_split(folder: Path, count: int, limits: Limits, step: int = 1) -> None:
    """Write ``count`` messages of 72 bytes, uncompressed, so that sizes are known."""
    writer = BagWriter(folder, limits=limits, compression="none")
    writer.attach("vessel.yaml", "application/yaml", b"name: x\n", 7)
    writer.attach("parameters/a.yaml", "application/yaml", b"first", 8)
    writer.describe("versions", {"python": "3"})
    writer.fresh = lambda: {"parameters/a.yaml": b"changed"}
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(count):
        writer.write(channel, message(k), 1000 + step * k, 900 + k, k)
    writer.close({"lost_messages": "0"})


def test_a_bag_split_by_size_is_one_to_rosbags_and_every_file_is_whole(tmp_path: Path) -> None:
    folder, count, size = tmp_path / "bag", 2000, 40_000
    write_split(folder, count, Limits(size=size))
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    names = information["relative_file_paths"]
    assert names == [f"bag_{k}.mcap" for k in range(len(names))]
    assert len(names) > 2
    assert sorted(path.name for path in folder.iterdir()) == sorted([*names, "metadata.yaml"])
    assert [file["path"] for file in information["files"]] == names
    assert sum(file["message_count"] for file in information["files"]) == information["message_count"] == count
    assert information["topics_with_message_count"][0]["message_count"] == count
    assert information["duration"] == {"nanoseconds": count - 1}

    start = 1000
    for number, file in enumerate(information["files"]):
        path = folder / file["path"]
        assert file["starting_time"] == {"nanoseconds_since_epoch": start}
        assert file["duration"] == {"nanoseconds": file["message_count"] - 1}
        start += file["message_count"]
        found = decoded(path)
        assert [raw.log_time for _, raw, _ in found] == list(range(start - file["message_count"], start))
        with path.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            attachments = {one.name: one for one in reader.iter_attachments()}
            records = {one.name: one.metadata for one in reader.iter_metadata()}
        assert summary is not None
        # The limit is that of the messages; no more than a sixteenth of it is left unused.
        messages = max(index.chunk_start_offset + index.chunk_length for index in summary.chunk_indexes)
        assert messages <= size + 2000  # index of the last chunk
        assert number == len(names) - 1 or messages > size * 0.9
        assert records["versions"] == {"python": "3"}
        assert attachments["vessel.yaml"].data == b"name: x\n"
        # What a further file repeats is known by its log time, and has what has changed since.
        repeated = attachments["parameters/a.yaml"]
        assert repeated.data == (b"changed" if number else b"first")
        assert repeated.create_time == 8
        assert (repeated.log_time > repeated.create_time) == (number > 0)
        own = yaml.safe_load(records["rosbag2"]["serialized_metadata"])
        assert own["relative_file_paths"] == [file["path"]]
        assert own["message_count"] == file["message_count"]

    with AnyReader([folder]) as reader:
        assert (reader.message_count, reader.start_time, reader.end_time) == (count, 1000, 1000 + count)
        assert [time for _, time, _ in reader.messages()] == list(range(1000, 1000 + count))
    with Reader(folder) as one:
        assert [time for _, time, _ in one.messages()] == list(range(1000, 1000 + count))


def test_a_bag_split_by_time(tmp_path: Path) -> None:
    write_split(tmp_path / "bag", 25, Limits(duration=1000), step=100)
    information = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert [file["message_count"] for file in information["files"]] == [10, 10, 5]


def test_a_message_larger_than_a_file_may_be_has_one_of_its_own(tmp_path: Path) -> None:
    write_split(tmp_path / "bag", 3, Limits(size=10))
    information = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert [file["message_count"] for file in information["files"]] == [1, 1, 1]


@pytest.mark.parametrize("room", [5000, 9000, 20_000])
def test_a_disk_that_fills_up_leaves_a_split_bag_whole(tmp_path: Path, room: int) -> None:
    """All files of the bag share one disk."""
    folder = tmp_path / "bag"
    disk = SharedDisk(room, folder / ".reserve")
    writer = BagWriter(folder, chunk_size=500, open_stream=disk.open, compression="none", limits=Limits(size=4000))
    channel = writer.add_topic(TOPIC, DEFINITION)

    def write_on() -> None:
        for k in range(100_000):
            writer.write(channel, message(k), k, k, k)

    with pytest.raises(RecordingStoppedError, match="No space left on device"):
        write_on()
    assert writer.disk_full
    with pytest.raises(RecordingStoppedError, match="No space left on device"):
        writer.close()
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    stamps: list[int] = []
    for name in information["relative_file_paths"]:
        stamps += [ros.header.stamp.sec for _, _, ros in decoded(folder / name)]
    assert stamps == list(range(information["message_count"]))
    assert len(stamps) == writer.message_count > 0


class SharedDisk:
    """Files that share the room of one disk."""

    def __init__(self, room: int, reserve: Path) -> None:
        self.room = room
        self.reserve = reserve
        self.used: dict[Path, int] = {}

    def open(self, path: Path) -> Any:
        return _OnDisk(self, path)


class _OnDisk(SmallDisk):
    def __init__(self, disk: SharedDisk, path: Path) -> None:
        self._disk = disk
        self._path = path
        super().__init__(path, 0, disk.reserve)

    def write(self, data: memoryview) -> int:
        others = sum(size for path, size in self._disk.used.items() if path != self._path)
        self._room = self._disk.room - others
        count = super().write(data)
        self._disk.used[self._path] = self._file.tell()
        return count

    def truncate(self, size: int) -> int:
        self._disk.used[self._path] = size
        return super().truncate(size)


def test_the_reserve_grows_with_the_summary(tmp_path: Path) -> None:
    """A chunk index for every half second of days: more than the first mebibyte."""
    writer = BagWriter(tmp_path / "bag")
    channel = writer.add_topic(TOPIC, DEFINITION)
    for k in range(12_000):
        writer.write(channel, message(0), k, k, k)
        writer.flush()
    reserve = tmp_path / "bag" / ".reserve"
    assert reserve.stat().st_size > RESERVE_BYTES
    before = writer.size
    kept = reserve.stat().st_size
    writer.close()
    summary = (tmp_path / "bag" / "bag_0.mcap").stat().st_size - before
    assert summary + (tmp_path / "bag" / "metadata.yaml").stat().st_size < kept
