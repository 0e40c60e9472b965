"""The recorder as a process of its own, over real DDS: what is published is in the bag."""

from __future__ import annotations

import os
import random
import re
import resource
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ThrusterCommand
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from std_msgs.msg import String

from dp_bringup.workspace import executable
from dp_node import RING, Level
from dp_tools.recorder.quality import DEPTH, matching_quality
from support.waiting import wait_until

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)


class Recording:
    """A recorder process."""

    def __init__(self, folder: Path, *parameters: str, prepare: Callable[[], None] | None = None) -> None:
        arguments = [part for parameter in (f"output:={folder}", *parameters) for part in ("-p", parameter)]
        self.process = subprocess.Popen(
            [executable("dp_tools", "recorder"), "--ros-args", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=prepare,
        )

    def end(self, number: int | None = signal.SIGINT) -> tuple[int, str, str]:
        """Stop it, or wait until it stops by itself; return exit code, standard output and error."""
        if number is not None:
            self.process.send_signal(number)
        out, error = self.process.communicate(timeout=30.0)
        return self.process.returncode, out, error


class Diagnostics:
    """What the recorder says of itself, taken without an executor."""

    def __init__(self, node: Node) -> None:
        self._subscription = node.create_subscription(DiagnosticArray, "/diagnostics", lambda message: None, RING)
        self.status: Any = None

    def take(self) -> None:
        while (taken := self._subscription.handle.take_message(DiagnosticArray, False)) is not None:
            self.status = taken[0].status[0]

    @property
    def level(self) -> int | None:
        return None if self.status is None else self.status.level[0]

    @property
    def values(self) -> dict[str, str]:
        return {value.key: value.value for value in self.status.values}


@pytest.fixture
def node(ros_domain_id: int) -> Iterator[Node]:
    rclpy.init()
    made = Node("talker")
    yield made
    made.destroy_node()
    rclpy.shutdown()


def until_heard(*publishers: Any) -> None:
    wait_until(lambda: all(publisher.get_subscription_count() > 0 for publisher in publishers))


def acknowledged(publisher: Any) -> None:
    assert publisher.wait_for_all_acked(Duration(seconds=20.0))


def decoded(folder: Path, topic: str) -> list[Any]:
    with (folder / f"{folder.name}_0.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [(raw, ros) for _, _, raw, ros in reader.iter_decoded_messages(topics=[topic])]


def information(folder: Path) -> dict[str, Any]:
    text = (folder / "metadata.yaml").read_text(encoding="utf-8")
    found: dict[str, Any] = yaml.safe_load(text)["rosbag2_bagfile_information"]
    return found


def odometry(k: int) -> Odometry:
    message = Odometry(child_frame_id="base_link_frd")
    message.header.frame_id = "map_ned"
    message.header.stamp.sec = k
    message.pose.pose.position.x = 0.1 * k
    message.pose.covariance[0] = -1.0
    return message


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_every_message_is_in_the_bag_with_its_times(node: Node, tmp_path: Path, number: int) -> None:
    folder = tmp_path / "bag"
    early = node.create_publisher(String, "latched", LATCHED)
    early.publish(String(data="said before anybody listened"))
    command = node.create_publisher(ThrusterCommand, "/ship/thruster_command", RING)
    recording = Recording(folder)
    until_heard(command, early)
    late = node.create_publisher(Odometry, "odometry", RING)
    sensor = node.create_publisher(String, "sensor", SENSOR)
    until_heard(late, sensor)

    before = time.time_ns()
    for k in range(20):
        late.publish(odometry(k))
        message = ThrusterCommand(name=["bow", "stern"], thrust=[0.5 * k, -1.0], azimuth=[0.0, 3.0])
        command.publish(message)
    sensor.publish(String(data="best effort"))
    for publisher in (late, command):
        acknowledged(publisher)
    after = time.time_ns()
    code, out, error = recording.end(number)
    # This node answers nobody.
    assert (code, error) == (0, "recorder: parameters of /talker are not in the bag: no answer\n")
    assert "lost 0" in out

    found = decoded(folder, "/odometry")
    assert [ros.header.stamp.sec for _, ros in found] == list(range(20))
    assert [raw.data for raw, _ in found] == [bytes(serialize_message(odometry(k))) for k in range(20)]
    assert [ros.pose.covariance[0] for _, ros in found] == [-1.0] * 20
    for raw, _ in found:
        assert before <= raw.publish_time <= raw.log_time
        assert raw.publish_time <= after
    assert [list(ros.thrust) for _, ros in decoded(folder, "/ship/thruster_command")] == [
        [0.5 * k, -1.0] for k in range(20)
    ]
    assert [ros.data for _, ros in decoded(folder, "/latched")] == ["said before anybody listened"]
    assert [ros.data for _, ros in decoded(folder, "/sensor")] == ["best effort"]

    with AnyReader([folder]) as reader:
        connections = [c for c in reader.connections if c.topic == "/odometry"]
        found = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections)]
    assert [message.pose.pose.position.x for message in found] == [0.1 * k for k in range(20)]
    topics = {t["topic_metadata"]["name"]: t for t in information(folder)["topics_with_message_count"]}
    assert topics["/odometry"]["message_count"] == 20
    assert topics["/odometry"]["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    assert topics["/latched"]["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    assert {"/diagnostics", "/rosout", "/parameter_events"} <= set(topics)
    assert not any("/_" in topic for topic in topics)


def test_nothing_is_lost_in_a_burst(node: Node, tmp_path: Path) -> None:
    """Thousands of messages as fast as one process can publish; no more than publisher and recorder can hold."""
    folder = tmp_path / "bag"
    count = 4000
    publisher = node.create_publisher(Odometry, "odometry", QoSProfile(depth=count))
    recording = Recording(folder)
    until_heard(publisher)
    for k in range(count):
        publisher.publish(odometry(k))
    acknowledged(publisher)
    code, out, _ = recording.end()
    assert code == 0
    assert "lost 0" in out
    assert [ros.header.stamp.sec for _, ros in decoded(folder, "/odometry")] == list(range(count))
    assert information(folder)["custom_data"]["lost_messages"] == "0"


def test_lost_messages_are_counted_and_named(node: Node, tmp_path: Path) -> None:
    """A recorder that is held up while more arrives than the middleware keeps."""
    folder = tmp_path / "bag"
    publisher = node.create_publisher(String, "chatter", RING)
    recording = Recording(folder)
    until_heard(publisher)
    publisher.publish(String(data="first"))
    acknowledged(publisher)
    os.kill(recording.process.pid, signal.SIGSTOP)
    count = DEPTH + 3000
    for k in range(count):
        publisher.publish(String(data=str(k)))
    os.kill(recording.process.pid, signal.SIGCONT)
    acknowledged(publisher)
    code, _, error = recording.end()
    assert code == 0
    match = re.search(r"lost messages: (\d+) on /chatter", error)
    assert match is not None
    kept = len(decoded(folder, "/chatter"))
    assert kept + int(match[1]) == count + 1
    assert information(folder)["custom_data"]["lost_messages"] == match[1]


def test_only_chosen_topics(node: Node, tmp_path: Path) -> None:
    publishers = [node.create_publisher(String, name, RING) for name in ("a", "b", "c")]
    recording = Recording(tmp_path / "bag", "topics:=[/a, /c]")
    until_heard(publishers[0], publishers[2])
    for publisher in publishers:
        publisher.publish(String(data="x"))
    acknowledged(publishers[0])
    acknowledged(publishers[2])
    assert recording.end()[0] == 0
    topics = [t["topic_metadata"]["name"] for t in information(tmp_path / "bag")["topics_with_message_count"]]
    assert sorted(topics) == ["/a", "/c", "/parameter_events"]


def test_vessel_and_scenario_are_attached(node: Node, tmp_path: Path) -> None:
    scenario = tmp_path / "calm.yaml"
    scenario.write_text("name: calm\n")
    publisher = node.create_publisher(String, "a", RING)
    recording = Recording(tmp_path / "bag", "vessel:=cybership3_ch7", f"scenario:={scenario}")
    until_heard(publisher)
    assert recording.end()[0] == 0
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as file:
        attachments = {a.name: a.data for a in make_reader(file).iter_attachments()}
    assert attachments["scenario.yaml"] == b"name: calm\n"
    assert yaml.safe_load(attachments["vessel.yaml"])["thrusters"][0]["position"][0] == 0.85
    assert information(tmp_path / "bag")["custom_data"]["vessel"] == "cybership3_ch7"


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (["vessel:=titanic"], "expected a path or one of cybership3, cybership3_ch7, cybership3_full_scale, "),
        (["scenario:=nowhere.yaml"], "nowhere.yaml: cannot be read: No such file or directory"),
        (["overwrite:=maybe"], "parameter overwrite"),
    ],
)
def test_bad_parameters_are_refused_before_anything_is_written(
    ros_domain_id: int, tmp_path: Path, parameters: list[str], message: str
) -> None:
    code, _, error = Recording(tmp_path / "bag", *parameters).end(None)
    assert code == 1
    assert message in error
    assert "Traceback" not in error
    assert not (tmp_path / "bag").exists()


def test_a_bag_that_is_there_is_refused(ros_domain_id: int, tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(b"precious")
    code, _, error = Recording(tmp_path / "bag").end(None)
    assert code == 1
    assert "holds a recording, which is not overwritten unless asked for" in error
    assert (tmp_path / "bag" / "bag_0.mcap").read_bytes() == b"precious"


def test_an_unwritable_folder_is_refused(ros_domain_id: int, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    code, _, error = Recording(tmp_path / "file" / "bag").end(None)
    assert code == 1
    assert "file/bag: cannot be written: Not a directory" in error


def test_a_write_that_fails_ends_the_recording_with_a_readable_bag(node: Node, tmp_path: Path) -> None:
    """A limit on the size of files is what the kernel offers without a disk to fill."""
    folder = tmp_path / "bag"
    limit = 2_500_000  # two chunks of 1 MiB that cannot be compressed, and room for the summary

    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    publisher = node.create_publisher(String, "noise", RING)
    recording = Recording(folder, prepare=small_files)
    until_heard(publisher)
    noise = random.Random(1)
    health = Diagnostics(node)

    def fill(_: float) -> None:
        publisher.publish(String(data=noise.randbytes(5_000).hex()))
        health.take()

    wait_until(
        lambda: health.level == Level.ERROR,
        timeout=60.0,
        message=lambda: f"an alarm, have {health.status}",
        spin=fill,
    )
    assert "File too large" in health.values["alarm.RECORDER-WRITE-FAILED"]
    # It is there to say so until it is told to end, and keeps nobody's messages meanwhile.
    wait_until(lambda: publisher.get_subscription_count() == 0)
    assert recording.process.poll() is None
    code, _, error = recording.end()
    assert code == 1
    assert "recording stopped: File too large" in error
    assert "Traceback" not in error
    kept = len(decoded(folder, "/noise"))
    assert kept > 0
    assert "File too large" in information(folder)["custom_data"]["stopped"]
    with AnyReader([folder]) as reader:
        assert reader.message_count == information(folder)["message_count"]


def test_a_publisher_that_offers_less_is_followed(node: Node, tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    strict = node.create_publisher(String, "mixed", RING)
    recording = Recording(folder)
    until_heard(strict)
    loose = node.create_publisher(String, "mixed", SENSOR)
    until_heard(loose)
    loose.publish(String(data="best effort"))
    strict.publish(String(data="reliable"))
    code, _, _ = recording.end()
    assert code == 0
    assert sorted(ros.data for _, ros in decoded(folder, "/mixed")) == ["best effort", "reliable"]


def test_quality_asks_for_what_all_publishers_offer() -> None:
    assert matching_quality([RING]).reliability == ReliabilityPolicy.RELIABLE
    assert matching_quality([RING]).durability == DurabilityPolicy.VOLATILE
    assert matching_quality([LATCHED]).durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert matching_quality([LATCHED, RING]).durability == DurabilityPolicy.VOLATILE
    assert matching_quality([RING, SENSOR]).reliability == ReliabilityPolicy.BEST_EFFORT
