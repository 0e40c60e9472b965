"""What is replayed under which name, with which quality, steered by which key."""

from __future__ import annotations

import os
import pty
import termios

import pytest
from rclpy.duration import Infinite
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from dp_node import RING_PUBLISHER
from dp_tools.bags.errors import BagError
from dp_tools.recorder.quality import describe_quality
from dp_tools.replay.keyboard import Keyboard, keys_in
from dp_tools.replay.quality import replayed_quality
from dp_tools.replay.selection import Selection, parse_remap

THERE = ["/pose", "/odometry", "/diagnostics", "/vessel_sim/transition_event"]

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.mark.parametrize(
    ("selection", "names"),
    [
        (Selection(), {name: name for name in THERE}),
        (Selection(topics=["pose"]), {"/pose": "/pose"}),
        (
            Selection(topics=["/*o*e*"], exclude=["/vessel_sim/*", "/diagnostics"]),
            {"/pose": "/pose", "/odometry": "/odometry"},
        ),
        (Selection(["pose"], remap=[("pose", "gps/pose")]), {"/pose": "/gps/pose"}),
        (
            Selection(["pose", "diagnostics"], remap=[("/pose", "/gps")], namespace="ship"),
            {"/pose": "/ship/gps", "/diagnostics": "/diagnostics"},
        ),
    ],
)
def test_names(selection: Selection, names: dict[str, str]) -> None:
    assert selection.names(THERE) == names


@pytest.mark.parametrize(
    ("selection", "message"),
    [
        (Selection(["wind"]), "--topics: expected a topic of the bag, found wind; it holds /pose, /odometry"),
        (Selection(exclude=["wind"]), "--exclude: expected a topic of the bag, found wind"),
        (Selection(remap=[("wind", "air")]), "--remap: expected a topic of the bag, found /wind"),
        (Selection(exclude=["*"]), "expected at least one topic to replay, found none"),
        (Selection(remap=[("pose", "odometry")]), "found /odometry for both /"),
        (Selection(remap=[("pose", "2 poses")]), "/pose: expected the name of a topic, found '/2 poses'"),
        (Selection(namespace="the ship"), "expected the name of a topic, found '/the ship/pose'"),
    ],
)
def test_selections_that_make_no_sense(selection: Selection, message: str) -> None:
    with pytest.raises(BagError, match=message.replace("*", r"\*")):
        selection.names(THERE)


@pytest.mark.parametrize("text", ["pose", "pose:=", ":=pose", "a=b"])
def test_remap_words(text: str) -> None:
    assert parse_remap("a:=/b") == ("a", "/b")
    with pytest.raises(BagError, match="--remap: expected old:=new, found"):
        parse_remap(text)


@pytest.mark.parametrize(
    "quality", [LATCHED, RING_PUBLISHER, QoSProfile(depth=7, reliability=ReliabilityPolicy.BEST_EFFORT)]
)
def test_quality_is_the_recorded_one(quality: QoSProfile) -> None:
    found = replayed_quality([describe_quality(quality)])
    assert (found.history, found.depth) == (quality.history, quality.depth)
    assert (found.reliability, found.durability) == (quality.reliability, quality.durability)
    assert found.deadline == found.lifespan == found.liveliness_lease_duration == Infinite


def test_quality_of_several_publishers_serves_all_their_readers() -> None:
    loose = describe_quality(QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    found = replayed_quality([loose, describe_quality(LATCHED)])
    assert found.reliability == ReliabilityPolicy.RELIABLE
    assert found.durability == DurabilityPolicy.TRANSIENT_LOCAL


@pytest.mark.parametrize(
    "offered", [[], [{}], [{"reliability": 77, "depth": "deep", "deadline": 3, "durability": None}]]
)
def test_quality_that_is_not_told_is_reliable_and_volatile(offered: list[dict[str, object]]) -> None:
    found = replayed_quality(offered)
    assert (found.reliability, found.durability) == (ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)
    assert found.history == HistoryPolicy.KEEP_LAST
    assert found.depth == 1000


def test_quality_as_bags_before_version_9_have_it() -> None:
    found = replayed_quality(
        [{"history": 1, "depth": 5, "reliability": 2, "durability": 1, "deadline": {"sec": 0, "nsec": 5}}]
    )
    assert (found.reliability, found.durability) == (ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.TRANSIENT_LOCAL)
    assert (found.depth, found.deadline.nanoseconds) == (5, 5)


def test_keys() -> None:
    assert keys_in(b" s\x1b[A\x1b[B\x1bOCq") == [" ", "s", "up", "down", "right", "q"]
    assert keys_in(b"\x1b[15~\x1b") == []
    assert keys_in(b"\x1b[1;5Dx") == ["x"]


def test_the_terminal_is_as_before_whatever_happens() -> None:
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)

    def interrupted() -> None:
        with Keyboard(theirs) as keyboard:
            assert not termios.tcgetattr(theirs)[3] & termios.ICANON
            assert keyboard.pressed() == []
            os.write(ours, b"s\x1b[C")
            assert keyboard.pressed() == ["s", "right"]
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)


def test_without_a_terminal_no_key_is_pressed() -> None:
    read, write = os.pipe()
    with Keyboard(read) as keyboard:
        os.write(write, b"q")
        assert not keyboard.there
        assert keyboard.pressed() == []
    os.close(read)
    os.close(write)
