"""Damaged bags: what is told of them, and what a repair saves. Cuts and flipped bits at any place."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader

from dp_tools.bags.bag import open_bag
from dp_tools.bags.check import Checked, check_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.repair import repair
from support.dp_here import Dp, dp_here
from support.made_bag import CLOCK, START, clock, make_bag, text

__all__ = ["dp_here"]

Content = list[tuple[str, int, int, int, bytes]]
VESSEL = b"name: some vessel\n"


@cache
def whole_bag() -> tuple[bytes, bytes]:
    """The MCAP file and metadata.yaml of a bag of several chunks."""
    with TemporaryDirectory() as folder:
        messages = [("/a", 0.01 * k, f"message {k} " + "x" * (k % 7)) for k in range(60)]
        messages += [("/clock", 0.02 * k + 0.001, clock(0.1 * k)) for k in range(30)]
        messages.sort(key=lambda message: message[1])
        bag = make_bag(Path(folder) / "bag", messages, {"/clock": CLOCK}, None, {"vessel.yaml": VESSEL}, chunk_size=600)
        return (bag / "bag_0.mcap").read_bytes(), (bag / "metadata.yaml").read_bytes()


@contextmanager
def bag_of(data: bytes, metadata: bytes | None = None) -> Iterator[Path]:
    """A bag with these bytes."""
    with TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        bag.mkdir()
        (bag / "bag_0.mcap").write_bytes(data)
        if metadata is not None:
            (bag / "metadata.yaml").write_bytes(metadata)
        yield bag


def content(path: Path) -> Content:
    """All messages of a bag, in the order of its files."""
    with open_bag(path) as bag:
        found = bag.messages
        return [
            (
                bag.topics[found.topic[row]].name,
                *(int(one[row]) for one in (found.sequence, found.log_time, found.publish_time)),
                bag.data(row),
            )
            for row in range(len(found))
        ]


def by_libraries(bag: Path) -> Content:
    """The same by the mcap library's indexed reader."""
    with (bag / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        read = [
            (channel.topic, message.sequence, message.log_time, message.publish_time, message.data)
            for _, channel, message in reader.iter_messages(log_time_order=False)
        ]
    assert summary.statistics.message_count == len(read)
    return read


def by_rosbags(bag: Path) -> list[bytes]:
    """Their serialized messages in order of log time."""
    with AnyReader([bag]) as reader:
        return [bytes(data) for _, _, data in reader.messages()]


@cache
def whole_content() -> Content:
    with bag_of(*whole_bag()) as bag:
        return content(bag)


def told(checked: Checked) -> str:
    return "\n".join(map(str, (*checked.structure, *checked.content)))


def test_a_whole_bag_is_whole() -> None:
    with bag_of(*whole_bag()) as bag:
        checked = check_bag(bag)
        assert (checked.whole, checked.messages, told(checked)) == (True, 90, "")
        assert by_libraries(bag) == content(bag)
        assert len(make_reader((bag / "bag_0.mcap").open("rb")).get_summary().chunk_indexes) > 5


# Each example writes and checks a bag or two.
@settings(max_examples=50)
@given(st.data())
def test_cut_anywhere_a_prefix_of_the_messages_is_saved(data: st.DataObject) -> None:
    file, metadata = whole_bag()
    cut = data.draw(st.integers(0, len(file) - 1))
    expected = whole_content()
    with bag_of(file[:cut], metadata) as bag:
        checked = check_bag(bag)
        assert checked.needs_repair
        if cut >= 8:
            assert "the file ends" in told(checked)
        readable = content(bag) if cut else []
        repaired = repair(bag)
        saved = content(bag)
        assert repaired.messages == {"bag_0.mcap": len(saved)}
        assert saved == expected[: len(saved)]
        assert len(saved) >= len(readable)
        if saved:
            assert by_libraries(bag) == saved
        after = check_bag(bag)
        assert after.whole or not saved, told(after)
        assert sorted(path.name for path in bag.iterdir()) == [
            "bag_0.mcap",
            "bag_0.mcap.damaged",
            "metadata.yaml",
            "metadata.yaml.damaged",
        ]
        assert (bag / "bag_0.mcap.damaged").read_bytes() == file[:cut]


def test_the_messages_of_a_cut_chunk_are_saved_as_far_as_they_go() -> None:
    """Blocks of zstd are 128 KiB: a chunk of ten of them, cut in the middle."""
    with TemporaryDirectory() as folder:
        import random

        noise = random.Random(1)
        messages = [("/a", 0.01 * k, noise.randbytes(4000).hex()) for k in range(160)]
        bag = make_bag(Path(folder) / "bag", messages, chunk_size=1 << 24)
        file = bag / "bag_0.mcap"
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
        (bag / "metadata.yaml").unlink()
        assert content(bag) == []
        assert repair(bag, Path(folder) / "new").messages["bag_0.mcap"] > 50
        saved = content(Path(folder) / "new")
        assert [data for *_, data in saved] == [text(message[2]) for message in messages[: len(saved)]]


# Each example writes and checks a bag or two.
@settings(max_examples=50)
@given(st.data())
def test_one_flipped_byte_is_told_of_or_changes_nothing(data: st.DataObject) -> None:
    file, metadata = whole_bag()
    place = data.draw(st.integers(0, len(file) - 1))
    damaged = bytearray(file)
    damaged[place] ^= data.draw(st.integers(1, 255))
    with bag_of(bytes(damaged), metadata) as bag:
        checked = check_bag(bag)
        if checked.whole:
            assert content(bag) == whole_content()
            with open_bag(bag) as opened:
                assert [one.data for one in opened.attachments] == [VESSEL]
        else:
            with TemporaryDirectory() as folder:
                if damaged[:8] == file[:8] or checked.messages:
                    repair(bag, Path(folder) / "new")
                    saved = content(Path(folder) / "new")
                    # Nothing that was not recorded, and all but what is in the damaged chunk.
                    assert set(saved) <= set(whole_content())
                    assert len(saved) >= len(whole_content()) - 20
                    if saved:
                        assert check_bag(Path(folder) / "new").structure == []


@given(st.binary(max_size=300), st.sampled_from([b"", whole_bag()[0][:8], whole_bag()[0][:200]]))
def test_random_bytes_are_no_bag(noise: bytes, start: bytes) -> None:
    with bag_of(start + noise) as bag:
        assert not check_bag(bag).whole
        try:
            with open_bag(bag) as opened:
                assert opened.cut_off
        except BagError:
            pass
        with TemporaryDirectory() as folder:
            repair(bag, Path(folder) / "new")


@pytest.mark.parametrize(
    "text_of_metadata",
    [
        "",
        "a: [",
        "rosbag2_bagfile_information: 3",
        "rosbag2_bagfile_information: {relative_file_paths: [other.mcap]}",
        "\0",
    ],
)
def test_metadata_that_is_none(dp_here: Dp, text_of_metadata: str) -> None:
    with bag_of(whole_bag()[0], text_of_metadata.encode()) as bag:
        for command in ("check", "info"):
            code, output = dp_here("bag", command, bag)
            assert code == 1
            assert "metadata.yaml" in output
            assert len(output.splitlines()) == 1


def test_metadata_that_says_something_else() -> None:
    file, metadata = whole_bag()
    document = yaml.safe_load(metadata)
    information = document["rosbag2_bagfile_information"]
    information["message_count"] = 91
    information["topics_with_message_count"][0]["message_count"] = 61
    information["topics_with_message_count"][1]["topic_metadata"]["offered_qos_profiles"][0]["depth"] = 3
    with bag_of(file, yaml.safe_dump(document).encode()) as bag:
        found = told(check_bag(bag))
    assert "metadata.yaml: message_count: it says 91, the bag holds 90" in found
    assert "metadata.yaml: /a: it says std_msgs/msg/String, 61 messages, the bag holds std_msgs/msg/String, 60" in found
    assert "metadata.yaml: /clock: another quality of service than in the file" in found
    with bag_of(file) as bag:
        assert "metadata.yaml: is not there: the recording was not closed" in told(check_bag(bag))


def test_killed_recorder(dp_here: Dp) -> None:
    """What a recorder leaves that was killed: chunks and no end. Told as such, repaired in place, then whole."""
    file, _ = whole_bag()
    end = file.index(b"\x0f\x04\0\0\0\0\0\0\0")  # end of data
    with bag_of(file[:end]) as bag:
        code, output = dp_here("bag", "check", bag)
        assert code == 1
        assert "bag_0.mcap: unfinished: its recorder was killed, or the file was cut; 90 messages are whole" in output
        code, output = dp_here("bag", "info", bag)
        assert code == 0
        assert "90 on 2 topics" in output
        assert "the file ends without a footer" in output
        code, output = dp_here("bag", "check", bag, "--repair")
        assert code == 0, output
        assert "repaired bag_0.mcap: 90 messages recovered" in output
        assert "whole: 90 messages can be read" in output
        assert by_libraries(bag) == whole_content()
        assert by_rosbags(bag) == [data for *_, data in sorted(whole_content(), key=lambda message: message[2])]
        code, output = dp_here("bag", "check", bag, "--repair")
        assert (code, output.splitlines()[-1]) == (0, "nothing to repair")


def test_an_earlier_original_is_not_replaced(tmp_path: Path) -> None:
    with bag_of(whole_bag()[0][:2000]) as bag:
        repair(bag)
        (bag / "bag_0.mcap").write_bytes(whole_bag()[0][:1000])
        with pytest.raises(BagError, match=r"bag_0\.mcap\.damaged: is there already, from an earlier repair"):
            repair(bag)


def test_a_bag_that_is_being_written_is_left_alone(tmp_path: Path) -> None:
    with bag_of(whole_bag()[0][:2000]) as bag, (bag / "bag_0.mcap").open("ab"):
        with pytest.raises(BagError, match=r"bag_0\.mcap: is being written by process \d+"):
            repair(bag)
        assert [path.name for path in bag.iterdir()] == ["bag_0.mcap"]


def test_bags_that_the_recorder_splits(tmp_path: Path) -> None:
    """Every file repeats attachments; a repair into one file has them once."""
    from dp_tools.recorder.bag_metadata import TopicInfo
    from dp_tools.recorder.bag_writer import BagWriter, Limits

    writer = BagWriter(tmp_path / "bag", limits=Limits(duration=1_000_000_000))
    writer.attach("vessel.yaml", "application/yaml", VESSEL, START)
    writer.attach("parameters/node.yaml", "application/yaml", b"/**/node: {ros__parameters: {a: 1}}\n", START)
    channel = writer.add_topic(TopicInfo("/a", "std_msgs/msg/String"), "string data\n")
    for k in range(50):
        at = START + k * 100_000_000
        writer.write(channel, text(str(k)), at, at, k + 1)
    writer.close()
    bag = tmp_path / "bag"
    assert len(list(bag.glob("*.mcap"))) >= 4
    checked = check_bag(bag)
    assert (told(checked), checked.messages) == ("", 50)
    whole = content(bag)
    (bag / "metadata.yaml").unlink()
    assert repair(bag, tmp_path / "one").messages["bag_1.mcap"] > 0
    assert content(tmp_path / "one") == whole
    with open_bag(tmp_path / "one") as opened:
        assert [one.name for one in opened.attachments] == ["vessel.yaml", "parameters/node.yaml"]


def test_one_file_by_itself(tmp_path: Path) -> None:
    file = tmp_path / "alone.mcap"
    file.write_bytes(whole_bag()[0][:-30])
    assert repair(file).kept == [tmp_path / "alone.mcap.damaged"]
    assert content(file) == whole_content()
    assert check_bag(file).whole
    assert sorted(path.name for path in tmp_path.iterdir()) == ["alone.mcap", "alone.mcap.damaged"]


def test_split_bags_are_one(tmp_path: Path) -> None:
    """Eleven files by number; the last one cut."""
    whole = []
    bag = tmp_path / "bag"
    bag.mkdir()
    for k in range(11):
        part = make_bag(tmp_path / "part", [("/a", k + 0.1 * i, f"{k} {i}") for i in range(3)])
        whole += content(part)
        shutil.copy(part / "part_0.mcap", bag / f"bag_{k}.mcap")
        shutil.rmtree(part)
    assert content(bag) == whole
    last = bag / "bag_10.mcap"
    last.write_bytes(last.read_bytes()[:-20])
    found = told(check_bag(bag))
    assert "bag_10.mcap: unfinished" in found
    assert "bag_9" not in found
    repair(bag)
    assert content(bag) == whole


@pytest.mark.parametrize("compression", [CompressionType.LZ4, CompressionType.NONE, CompressionType.ZSTD])
@pytest.mark.parametrize("chunked", [True, False])
def test_files_of_the_librarys_writer(compression: CompressionType, chunked: bool, tmp_path: Path) -> None:
    stream = BytesIO()
    writer = Writer(stream, compression=compression, use_chunking=chunked, chunk_size=300, enable_data_crcs=True)
    writer.start("ros2", "test")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channel = writer.register_channel("/a", "cdr", schema)
    for k in range(50):
        writer.add_message(channel, START + k, text(str(k)), START + k, k + 1)
    writer.add_attachment(START, START, "vessel.yaml", "application/yaml", VESSEL)
    writer.finish()
    file = tmp_path / "a.mcap"
    file.write_bytes(stream.getvalue())
    checked = check_bag(file)
    assert (told(checked), checked.messages) == ("", 50)
    assert [data for *_, data in content(file)] == [text(str(k)) for k in range(50)]
    file.write_bytes(stream.getvalue()[:-20])
    assert repair(file).messages == {"a.mcap": 50}
    assert [data for *_, data in content(file)] == [text(str(k)) for k in range(50)]


def test_what_is_wrong_with_the_messages(tmp_path: Path) -> None:
    from geometry_msgs.msg import Vector3Stamped

    def vector(stamp: int, x: float) -> Vector3Stamped:
        message = Vector3Stamped()
        message.header.stamp.sec = stamp
        message.vector.x = x
        return message

    kinds = {"/wind": "geometry_msgs/msg/Vector3Stamped", "/other": "geometry_msgs/msg/Vector3Stamped"}
    messages = [("/wind", 0.0, vector(5, 1.0)), ("/wind", 0.2, vector(6, float("nan"))), ("/wind", 0.1, vector(4, 1.0))]
    messages += [("/other", 0.0, vector(0, float("inf")))]
    bag = make_bag(tmp_path / "bag", messages, kinds)
    checked = check_bag(bag)
    assert not checked.needs_repair
    assert not checked.whole
    assert [str(finding) for finding in checked.content if finding.wrong] == [
        "/wind: log time goes back 1 times, first at message 2",
        "/wind: publish time goes back 1 times, first at message 2",
        "/wind: vector.x: NaN or infinite in 1 of 3 messages, first in 1",
        "/wind: header.stamp goes back 1 times, first at message 2",
    ]
    assert "/other: vector.x: no number in any message" in told(checked)


def test_lost_messages_and_messages_of_another_type(tmp_path: Path) -> None:
    from dp_tools.recorder.bag_metadata import TopicInfo
    from dp_tools.recorder.bag_writer import BagWriter

    writer = BagWriter(tmp_path / "bag")
    one = writer.add_topic(TopicInfo("/a", "std_msgs/msg/String"), "string data\n")
    two = writer.add_topic(TopicInfo("/b", "std_msgs/msg/String"), "string data\n")
    for number in (3, 4, 7, 1, 2):  # two lost; then a publisher begins anew
        writer.write(one, text("x"), START, START, number)
    writer.write(two, b"\0\1\0\0\xff\xff\xff\x7f", START, START, 1)
    writer.close()
    found = told(check_bag(tmp_path / "bag"))
    assert "/a: 2 messages lost, by the publisher's numbers" in found
    assert "/b: message is not of type std_msgs/msg/String" in found


@pytest.mark.parametrize(
    ("definition", "reason"),
    [
        ("builtin_interfaces/Time clock\n", "builtin_interfaces/msg/Time is not defined"),
        (
            "builtin_interfaces/Time clock\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\nint32 sec\n",
            "builtin_interfaces/msg/Time: expected sec, nanosec, found sec",
        ),
    ],
)
def test_a_definition_that_lacks_something(definition: str, reason: str, tmp_path: Path) -> None:
    bag = make_bag(tmp_path / "bag", [("/clock", 0.1, clock(0.1))], {"/clock": CLOCK}, definitions={CLOCK: definition})
    assert f"/clock: the definition of {CLOCK} cannot be understood: {reason}" in told(check_bag(bag))


def test_a_repair_keeps_the_messages_about_one_of_an_impossible_time(tmp_path: Path) -> None:
    messages = [("/a", float(k), f"message {k}") for k in range(5)]
    bag = make_bag(tmp_path / "bag", messages, chunk_size=1 << 20)
    with (bag / "bag_0.mcap").open("rb") as stream:
        read = [(channel.topic, message) for _, channel, message in make_reader(stream).iter_messages()]
    spoilt = tmp_path / "spoilt.mcap"
    with spoilt.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "test")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        for k, (_, message) in enumerate(read):
            time = (1 << 63) + 1 if k == 2 else message.log_time
            writer.add_message(channel, time, message.data, time, k + 1)
        writer.finish()
    with pytest.raises(BagError, match="message with the time 9223372036854775809 ns"):
        content(spoilt)
    done = repair(spoilt, tmp_path / "new")
    assert [data for *_, data in content(tmp_path / "new")] == [text(f"message {k}") for k in (0, 1, 3, 4)]
    assert "message with the time 9223372036854775809 ns" in " ".join(done.damage)
