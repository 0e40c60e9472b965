"""Events of the middleware about a node's topics: a real publisher in another process stops, dies and comes back."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from geometry_msgs.msg import WrenchStamped

from dp_node import RingNode
from dp_node.quality import OFFERED_LEASE
from marine_model.settings import Settings
from support.node_bench import NodeBench, node_bench

pytestmark = [pytest.mark.usefixtures("ros_domain_id"), pytest.mark.timeout(100)]

# Every tenth of a second, until it is killed. Its argument is the deadline that it offers.
PUBLISHER = """
import sys, rclpy
from geometry_msgs.msg import WrenchStamped
from dp_node.quality import Promise, offered
rclpy.init()
node = rclpy.create_node("peer")
quality = offered("tau_desired", Promise(0.0, float(sys.argv[1])))
publisher = node.create_publisher(WrenchStamped, "tau_desired", quality)
node.create_timer(0.1, lambda: publisher.publish(WrenchStamped()))
rclpy.spin(node)
"""
DEADLINE = 1.0


class ListenerNode(RingNode[Settings]):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__("listener", **kwargs)

    def default_settings(self, vessel: object) -> Settings:
        return Settings()

    def build(self) -> None:
        self.heard = 0
        self.listen(WrenchStamped, "tau_desired", self.on_demand)

    def on_demand(self, message: Any) -> None:
        self.heard += 1


@contextmanager
def peer() -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen([sys.executable, "-c", PUBLISHER, str(DEADLINE)])
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def alarm(bench: NodeBench, code: str) -> str:
    return str(bench.diagnostics().get(f"alarm.{code}", ""))


def test_a_peer_that_stops_is_late_then_gone_and_comes_back(ros_domain_id: int) -> None:
    with node_bench(ListenerNode, input_lease=OFFERED_LEASE, input_deadline=DEADLINE) as bench, peer() as process:
        node = bench.node
        assert isinstance(node, ListenerNode)
        bench.wait_until(lambda: node.heard > 3, "messages of the peer")
        process.send_signal(signal.SIGSTOP)
        seen: set[str] = set()

        def stopped() -> bool:
            seen.update(key for key in bench.diagnostics() if key.startswith("alarm."))
            return {"alarm.NODE-DEADLINE-MISSED", "alarm.NODE-LIVELINESS-LOST"} <= seen

        bench.wait_until(stopped, lambda: f"both alarms, seen are {seen}")
        process.send_signal(signal.SIGCONT)
        bench.wait_until(lambda: not alarm(bench, "NODE-LIVELINESS-LOST"), "the peer to be back")
        count = node.heard
        bench.wait_until(lambda: node.heard > count + 3, "messages of the peer again")
        process.kill()
        bench.wait_until(lambda: alarm(bench, "NODE-LIVELINESS-LOST").endswith(": tau_desired"), "the peer to be gone")


def test_a_publisher_that_offers_less_is_named_with_its_policy_while_it_is_there(ros_domain_id: int) -> None:
    with node_bench(ListenerNode, input_lease=OFFERED_LEASE) as bench:
        foreign = bench.probe.create_publisher(WrenchStamped, "tau_desired", 10)
        bench.wait_until(lambda: alarm(bench, "NODE-QOS-INCOMPATIBLE"), "the alarm")
        assert alarm(bench, "NODE-QOS-INCOMPATIBLE").endswith("tau_desired, liveliness, 1 of its ends")
        bench.probe.destroy_publisher(foreign)
        bench.wait_until(lambda: not alarm(bench, "NODE-QOS-INCOMPATIBLE"), "the alarm to be over")


def test_a_publisher_with_default_settings_is_heard_by_a_node_launched_alone(ros_domain_id: int) -> None:
    with node_bench(ListenerNode) as bench:
        foreign = bench.probe.create_publisher(WrenchStamped, "tau_desired", 10)
        bench.wait_until(lambda: foreign.get_subscription_count() == 1, "the node to listen")
        foreign.publish(WrenchStamped())
        bench.wait_until(lambda: bench.node.heard == 1, "the message")  # type: ignore[attr-defined]
        assert bench.diagnostics()["level"] == 0
