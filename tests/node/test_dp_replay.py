"""`dp replay` over real DDS: what was recorded is heard again, in order, as it was sent."""

from __future__ import annotations

import itertools
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from dp_node import RingExecutor
from support.dp_command import DpProcess
from support.dp_here import Dp, dp_here
from support.made_bag import CLOCK, LATCHED, START, clock, make_bag, text
from support.waiting import wait_until

__all__ = ["dp_here"]

KEEP = QoSProfile(depth=1000)
LATE = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NANOSECONDS = 1_000_000_000


class Listener:
    """Hears what is published: serialized, with the publisher's time."""

    def __init__(self) -> None:
        self.node = Node("listener")
        self.executor = RingExecutor()
        self.executor.add_node(self.node)
        self.heard: list[tuple[str, bytes]] = []
        self.times: list[int] = []

    def listen(self, topic: str, kind: Any = String, quality: QoSProfile = KEEP) -> None:
        def note(data: bytes, info: dict[str, Any]) -> None:
            self.heard.append((topic, data))
            self.times.append(info["source_timestamp"])

        self.node.create_subscription(kind, topic, note, quality, raw=True)

    def wait_until(self, condition: Any, message: str, process: DpProcess) -> None:
        wait_until(
            condition,
            timeout=60.0,
            message=lambda: f"{message}; heard {self.heard[-5:]}; it said:\n{process.output}",
            spin=lambda seconds: self.executor.spin_once(timeout_sec=seconds),
        )

    def hear(self, count: int, process: DpProcess) -> list[tuple[str, bytes]]:
        self.wait_until(lambda: len(self.heard) >= count, f"{count} messages", process)
        return self.heard

    def call(self, service: str, process: DpProcess) -> str:
        """Call a service of the replay, once: a step taken twice would be two."""
        client = self.node.create_client(Trigger, f"/dp_replay/{service}")
        self.wait_until(client.service_is_ready, service, process)
        future = client.call_async(Trigger.Request())
        self.wait_until(future.done, f"an answer of {service}", process)
        self.node.destroy_client(client)
        return future.result().message


@pytest.fixture
def listener(ros_domain_id: int) -> Iterator[Listener]:
    rclpy.init()
    made = Listener()
    yield made
    made.executor.shutdown()
    made.node.destroy_node()
    rclpy.shutdown()


def test_messages_order_times_names_and_what_cannot_be_played(listener: Listener, tmp_path: Path) -> None:
    messages = [("/a", 0.02 * k, str(k)) for k in range(50)] + [("/b", 0.02 * k + 0.01, f"b{k}") for k in range(50)]
    alien = {"kinds": {"/alien": "alien_msgs/msg/Probe"}, "definitions": {"alien_msgs/msg/Probe": "string data\n"}}
    bag = make_bag(tmp_path / "bag", [*messages, ("/alien", 0.5, "?"), ("/left_out", 0.5, "?")], **alien)
    for topic in ("/a", "/ship/other/b", "/left_out", "/ship/a"):
        listener.listen(topic)
    words = ("--rate", "2", "--remap", "b:=other/b", "--exclude", "left_out", "--namespace", "ship", "--start", "0.1")
    with DpProcess("replay", bag, *words, "--wait", "30", "--topics", "*") as process:
        heard = listener.hear(90, process)
        code = process.wait()
        output = process.output
    assert code == 0, output
    expected = sorted(messages, key=lambda message: message[1])[10:]
    names = {"/a": "/ship/a", "/b": "/ship/other/b"}
    # In the order they were sent: an executor that finds messages of several topics waiting takes topic by topic.
    in_order = [message for _, message in sorted(zip(listener.times, heard, strict=True))]
    assert in_order == [(names[topic], text(content)) for topic, _, content in expected]
    assert "warning: /alien: not played: message type alien_msgs/msg/Probe: not installed on this machine" in output
    late = re.search(r"sent +90 messages; late by at most ([\d.]+) ms", output)
    assert late is not None, output
    # Distances differ from the recorded ones by no more than the lateness that the replay itself tells of.
    worst = float(late[1]) * 1e-3
    for (_, due, _), time in zip(expected, sorted(listener.times), strict=True):
        after = (time - min(listener.times)) / NANOSECONDS - (due - expected[0][1]) / 2.0
        # 0.1 s for what may come between the decision to send and the middleware's own time stamp on a busy machine.
        assert abs(after) <= worst + 0.1


def test_steps_pause_and_late_readers(listener: Listener, tmp_path: Path) -> None:
    """Nothing is sent unless asked for; who comes late hears the last message of a latched topic."""
    messages = [("/latched", 0.0, "state"), ("/clock", 0.0, clock(12.5))]
    for k in range(5):
        messages += [("/pose", 1.0 + k, f"pose {k}"), ("/odometry", 1.1 + k, f"odometry {k}")]
    bag = make_bag(tmp_path / "bag", messages, {"/clock": CLOCK}, {"/latched": LATCHED})
    for topic in ("/pose", "/odometry"):
        listener.listen(topic)
    listener.listen("/clock", Clock)
    with DpProcess("replay", bag, "--paused", "--rate", "1000") as process:
        assert listener.call("pause", process) == "bag time 0.000000 s, 0 messages sent"
        assert listener.heard == []
        assert listener.call("step", process).startswith("1 message, ")
        assert listener.call("step", process).startswith("1 message, ")
        assert listener.hear(1, process) == [("/clock", clock(12.5))]
        listener.listen("/latched", quality=LATE)
        assert listener.hear(2, process)[1] == ("/latched", text("state"))
        assert listener.call("step_sample", process) == "2 messages, bag time 1.100000 s, 4 messages sent"
        assert listener.hear(4, process)[2:] == [("/pose", text("pose 0")), ("/odometry", text("odometry 0"))]
        listener.call("resume", process)
        heard = listener.hear(12, process)
        assert process.wait() == 0, process.output
    assert [content for topic, content in heard if topic == "/odometry"] == [text(f"odometry {k}") for k in range(5)]


def test_clock_from_bag_time_loop_and_end_by_signal(listener: Listener, tmp_path: Path) -> None:
    bag = make_bag(tmp_path / "bag", [("/a", 0.05 * k, str(k)) for k in range(10)], {}, {})
    listener.listen("/a")
    listener.listen("/clock", Clock)
    with DpProcess("replay", bag, "--clock", "100", "--loop", "--wait", "30") as process:
        listener.wait_until(
            lambda: [topic for topic, _ in listener.heard].count("/a") >= 25, "the third round", process
        )
        process.signal(signal.SIGTERM)
        assert process.wait() == 0, process.output
    told = [
        int.from_bytes(data[4:8], "little") * NANOSECONDS + int.from_bytes(data[8:12], "little")
        for topic, data in listener.heard
        if topic == "/clock"
    ]
    assert len(told) > 20
    assert all(0 <= time - START <= 450_000_000 for time in told)
    back = sum(after < before for before, after in itertools.pairwise(told))
    assert 2 <= back <= 3
    assert [data for topic, data in listener.heard if topic == "/a"][:25] == [text(str(k % 10)) for k in range(25)]


@pytest.mark.usefixtures("ros_domain_id")
def test_nobody_listens(dp_here: Dp, tmp_path: Path) -> None:
    bag = make_bag(tmp_path / "bag", [("/a", 0.0, "x")])
    code, output = dp_here("replay", bag, "--wait", "0.5")
    assert code == 1
    assert "error: waited 0.5 s for subscribers of /a" in output
