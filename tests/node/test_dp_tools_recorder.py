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
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import rclpy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ThrusterCommand
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from std_msgs.msg import String

from dp_bringup.parameter_file import read_parameter_file
from dp_bringup.workspace import executable
from dp_node import RING, Level
from dp_tools.recorder.quality import DEPTH, matching_quality
from support.dp_command import DpProcess
from support.dp_here import Dp, dp_here
from support.waiting import wait_until

__all__ = ["dp_here"]

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


# Parameters of nodes -------------------------------------------------------------------------------------------------


def records_so_far(path: Path) -> list[Any]:
    """Return what the library's stream reader finds in a file that has no end yet."""
    found: list[Any] = []
    with path.open("rb") as stream, suppress(EndOfFile):
        # Not list(): what comes before the end counts.
        for record in StreamReader(stream, validate_crcs=True).records:
            found.append(record)  # noqa: PERF402
    return found


def attached(path: Path, name: str) -> list[Attachment]:
    return [one for one in records_so_far(path) if isinstance(one, Attachment) and one.name == name]


def values_of(attachment: Attachment, folder: Path) -> dict[str, Any]:
    (folder / "read.yaml").write_bytes(attachment.data)
    return read_parameter_file(folder / "read.yaml")["worker"]


def worker(gain: float) -> Node:
    made = Node("worker", namespace="/ship")
    made.declare_parameter("gain", gain)
    made.declare_parameter("words", ["a", "no"])
    made.declare_parameter("size", 3, ParameterDescriptor(read_only=True))
    made.declare_parameter("unset", Parameter.Type.DOUBLE)  # rclpy then answers nothing to who asks for all
    return made


def test_parameters_of_a_node_are_in_the_bag_at_every_start_and_with_every_change(node: Node, tmp_path: Path) -> None:
    path, name = tmp_path / "bag" / "bag_0.mcap", "parameters/ship/worker.yaml"
    executor = SingleThreadedExecutor()

    def spin(seconds: float) -> None:
        executor.spin_once(timeout_sec=seconds)

    recording = Recording(tmp_path / "bag")
    wait_until(path.exists)
    first = worker(1.5)
    executor.add_node(first)
    wait_until(lambda: attached(path, name), spin=spin, message="the parameters of the node")
    # The event reaches only who is matched; then the change is told to everybody that listens.
    wait_until(lambda: node.count_subscribers("/parameter_events") > 0)
    first.set_parameters([Parameter("gain", value=2.5)])
    executor.remove_node(first)
    first.destroy_node()
    second = worker(4.0)
    executor.add_node(second)
    wait_until(lambda: len(attached(path, name)) == 2, spin=spin, message="the parameters of the next life")
    code, _, error = recording.end()
    assert code == 0
    # This one never spins, so it cannot answer.
    assert "recorder: parameters of /talker are not in the bag: no answer\n" in error
    assert "/talker" in information(tmp_path / "bag")["custom_data"]["parameters_missing"]
    second.destroy_node()

    before, after = attached(path, name)
    expected = {"gain": 1.5, "size": 3, "use_sim_time": False, "words": ["a", "no"]}
    assert values_of(before, tmp_path) == expected
    assert values_of(after, tmp_path) == expected | {"gain": 4.0}
    events = [(raw, ros) for raw, ros in decoded(tmp_path / "bag", "/parameter_events") if ros.node == "/ship/worker"]
    ((changed, change),) = [(raw, ros) for raw, ros in events if ros.changed_parameters]
    assert [(one.name, one.value.double_value) for one in change.changed_parameters] == [("gain", 2.5)]
    # Times tell what came first.
    assert before.log_time < changed.publish_time < after.log_time
    assert before.create_time == before.log_time
    # The recorder's own are there as well, and nobody's who is hidden.
    own = attached(path, "parameters/recorder.yaml")
    assert len(own) == 1
    assert b"compression: zstd" in own[0].data
    assert not [one for one in records_so_far(path) if isinstance(one, Attachment) and "/_" in one.name]


# Killed --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compression", ["zstd", "none"])
def test_a_recorder_that_is_killed_loses_less_than_a_second(node: Node, tmp_path: Path, compression: str) -> None:
    path = tmp_path / "bag" / "bag_0.mcap"
    publisher = node.create_publisher(Odometry, "odometry", RING)
    recording = Recording(tmp_path / "bag", f"compression:={compression}", "vessel:=cybership3")
    until_heard(publisher)
    sent: list[int] = []  # wall-clock times, ns

    def publish() -> None:
        sent.append(time.time_ns())
        publisher.publish(odometry(len(sent) - 1))

    timer = node.create_timer(0.0005, publish)  # as fast as a ring in lockstep, not as fast as it goes
    wait_until(lambda: sent and sent[-1] - sent[0] > 2_500_000_000, spin=lambda s: rclpy.spin_once(node, timeout_sec=s))
    node.destroy_timer(timer)
    recording.process.kill()
    killed = time.time_ns()
    recording.process.wait(timeout=20.0)
    assert not (tmp_path / "bag" / "metadata.yaml").exists()

    records = records_so_far(path)
    numbers = {one.id for one in records if isinstance(one, Channel) and one.topic == "/odometry"}
    found = [one for one in records if isinstance(one, Message) and one.channel_id in numbers]
    # Nothing is missing before the end, and the end is less than a second before the kill.
    assert [one.data for one in found] == [bytes(serialize_message(odometry(k))) for k in range(len(found))]
    assert len(found) < len(sent)
    assert killed - sent[len(found)] < 1_000_000_000
    assert attached(path, "vessel.yaml")


# dp record -----------------------------------------------------------------------------------------------------------


def test_dp_record_takes_what_is_asked_for_and_splits(node: Node, tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    wanted, other, unwanted = (node.create_publisher(Odometry, name, RING) for name in ("a", "/x/odo", "/x/odo_raw"))
    words = ("a", "--regex", "odo", "--exclude", "raw$", "--max-size", "0.03", "--compression", "lz4")
    with DpProcess("record", *words, "--output", folder) as process:
        process.wait_until(lambda: wanted.get_subscription_count() and other.get_subscription_count(), "recording")
        for k in range(1500):
            wanted.publish(odometry(k))
            if k % 300 == 0:
                acknowledged(wanted)  # no more than what a publisher keeps
        acknowledged(wanted)
        other.publish(odometry(7))
        acknowledged(other)
        assert unwanted.get_subscription_count() == 0
        process.signal(signal.SIGINT)
        assert process.wait() == 0
        output = process.output
    files = information(folder)["relative_file_paths"]
    assert len(files) > 1
    assert f"recording to {folder}/bag_0.mcap" in output
    assert re.search(rf"recorded \d+ messages on \d topics, \d\.\d MB in {len(files)} files, lost 0", output)
    for name in files:
        with (folder / name).open("rb") as file:
            reader = make_reader(file)
            summary = reader.get_summary()
            assert {index.compression for index in summary.chunk_indexes} == {"lz4"}
            assert "parameters/recorder.yaml" in [one.name for one in reader.iter_attachments()]
    with AnyReader([folder]) as reader:
        assert {c.topic for c in reader.connections} == {"/a", "/x/odo", "/parameter_events"}
        connections = [c for c in reader.connections if c.topic == "/a"]
        messages: list[Any] = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections)]
        found = [message.header.stamp.sec for message in messages]
    assert found == list(range(1500))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--regex", "["), "regex: expected a regular expression, found '['"),
        (("--vessel", "titanic"), "expected a path or one of cybership3"),
        (("--namespace", "1ship"), "namespace"),
        (("--max-size", "2000000"), "parameter max_size"),
    ],
)
def test_what_dp_record_refuses(
    ros_domain_id: int,
    dp_here: Dp,
    tmp_path: Path,
    words: tuple[str, ...],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(signal, "signal", lambda number, handler: None)  # this process keeps its own
    code, output = dp_here("record", *words, "--output", tmp_path / "bag")
    assert code == 1
    assert message in output
    assert len(output.splitlines()) == 1
    assert not (tmp_path / "bag").exists()
