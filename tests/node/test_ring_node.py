"""The base class of the nodes that answer: what they hear at the start, in lockstep and in real time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from dp_node import RING_PUBLISHER, RingExecutor, RingNode
from marine_model.settings import Settings
from support.waiting import wait_until

pytestmark = pytest.mark.usefixtures("ros_domain_id")


class ListenerNode(RingNode[Settings]):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__("listener", **kwargs)

    def default_settings(self, vessel: object) -> Settings:
        return Settings()

    def build(self) -> None:
        self.heard: list[float] = []
        self.listen(WrenchStamped, "ping", lambda message: self.heard.append(message.wrench.force.x))


def ping(force: float) -> WrenchStamped:
    message = WrenchStamped()
    message.wrench.force.x = force
    return message


@contextmanager
def late_listener(synchronous: bool, quality: QoSProfile) -> Iterator[tuple[ListenerNode, Any, RingExecutor]]:
    """A node that comes when a first ping has been sent already, with its executor and the publisher."""
    rclpy.init()
    executor = RingExecutor()
    sender = rclpy.create_node("sender")
    nodes = [sender]
    try:
        publisher = sender.create_publisher(WrenchStamped, "ping", quality)
        publisher.publish(ping(1.0))
        listener = ListenerNode(parameter_overrides=[Parameter("synchronous", value=synchronous)])
        nodes.append(listener)
        listener.start()
        for node in nodes:
            executor.add_node(node)
        yield listener, publisher, executor
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()


def spin(executor: RingExecutor, seconds: float) -> None:
    executor.spin_once(timeout_sec=seconds)


@pytest.mark.parametrize(("synchronous", "heard"), [(True, [1.0, 2.0]), (False, [2.0])])
def test_only_lockstep_hears_what_was_sent_before(synchronous: bool, heard: list[float]) -> None:
    """Lockstep sends once and waits; in real time a restarted node must not act on an old sample."""
    with late_listener(synchronous, RING_PUBLISHER) as (listener, publisher, executor):
        wait_until(lambda: publisher.get_subscription_count() == 1, spin=lambda s: spin(executor, s))
        publisher.publish(ping(2.0))
        # Messages of one publisher come in order: with the second, the first would be here.
        wait_until(lambda: listener.heard[-1:] == [2.0], spin=lambda s: spin(executor, s))
        assert listener.heard == heard


def test_in_real_time_a_publisher_that_keeps_nothing_is_heard() -> None:
    """As sensors and the ros2 command publish."""
    with late_listener(False, QoSProfile(depth=10)) as (listener, publisher, executor):
        wait_until(lambda: publisher.get_subscription_count() == 1, spin=lambda s: spin(executor, s))
        publisher.publish(ping(2.0))
        wait_until(lambda: listener.heard == [2.0], spin=lambda s: spin(executor, s))
