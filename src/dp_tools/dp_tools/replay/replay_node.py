"""The replay as a ROS node: publishers of recorded topics, a clock, and services to steer it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from dp_bringup.message_types import MessageTypeError, message_class
from dp_node import from_nanoseconds
from dp_node.hand_over import hand_over
from dp_tools.bags.bag import Bag, BagTopic
from dp_tools.bags.errors import BagError
from dp_tools.replay.player import Player
from dp_tools.replay.quality import replayed_quality

CLOCK_KIND = "rosgraph_msgs/msg/Clock"


class Outlets:
    """Publishers of the topics of a bag.

    Parameters
    ----------
    node
        Publishes.
    bag
        What is published.
    names
        Name to publish on by recorded name.
    warn
        Told why a topic cannot be played.

    Raises
    ------
    BagError
        If no topic can be played, or one of them has messages of two types.
    """

    def __init__(self, node: Node, bag: Bag, names: Mapping[str, str], warn: Callable[[str], None]) -> None:
        self._bag = bag
        self.publishers: dict[str, Publisher] = {}
        """By recorded name."""
        for topic in bag.topics:
            if topic.name in names and topic.name not in self.publishers:
                try:
                    found = _class(topic)
                except BagError as error:
                    warn(f"{topic.name}: not played: {error}")
                    continue
                alike = [one for one in bag.topics if one.name == topic.name and one.kind == topic.kind]
                quality = replayed_quality([offer for one in alike for offer in one.offered_quality])
                self.publishers[topic.name] = node.create_publisher(found, names[topic.name], quality)
        if not self.publishers:
            raise BagError(f"{bag.files.path}: none of its topics can be played here")
        for topic in bag.topics:
            if topic.name in self.publishers and topic.kind != _kind(bag, topic.name):
                raise BagError(f"{topic.name}: expected one type, found {_kind(bag, topic.name)} and {topic.kind}")
        self._send = [
            self.publishers[topic.name].handle.publish_raw if topic.name in self.publishers else None
            for topic in bag.topics
        ]
        self._topic = bag.messages.topic.tolist()

    @property
    def played(self) -> frozenset[str]:
        """Recorded names of the topics that can be played."""
        return frozenset(self.publishers)

    @property
    def names(self) -> list[str]:
        """Names on which is published."""
        return [publisher.topic_name for publisher in self.publishers.values()]

    def send(self, row: int) -> None:
        """Publish a message of the bag."""
        send = self._send[self._topic[row]]
        if send is not None:
            send(self._bag.data(row))

    def listeners(self) -> dict[str, int]:
        """Return the number of subscribers by recorded name."""
        return {name: publisher.get_subscription_count() for name, publisher in self.publishers.items()}

    def settle(self) -> None:
        """Wait until everything sent is acknowledged, not longer than a reader that is alive needs."""
        hand_over(self.publishers.values())


def _kind(bag: Bag, name: str) -> str:
    return next(topic.kind for topic in bag.topics if topic.name == name)


def _class(topic: BagTopic) -> Any:
    """Return the message class of a topic. Raises BagError."""
    if topic.encoding != "cdr":
        raise BagError(f"expected messages in cdr, found {topic.encoding or 'none'}")
    try:
        return message_class(topic.kind)
    except MessageTypeError as error:
        raise BagError(str(error)) from error


class BagClock:
    """Publishes a clock made from bag time, for bags that hold none.

    Parameters
    ----------
    node
        Publishes.
    topic
        Name.
    hertz
        Messages a wall second, above 0; also while the replay stands.
    origin
        Bag time 0, ns since 1970.
    """

    def __init__(self, node: Node, topic: str, hertz: float, origin: int) -> None:
        self._publisher = node.create_publisher(Clock, topic, QoSProfile(depth=10))
        self._period = round(1e9 / hertz)
        self._origin = origin
        self.next = 0
        """Wall time at which it is due, ns."""

    def tick(self, now: int, position: int) -> None:
        """Publish if it is due; ``now`` wall time, ``position`` bag time, ns."""
        if now < self.next:
            return
        self._publisher.publish(Clock(clock=from_nanoseconds(self._origin + position)))
        # On a fixed grid; what was missed is left out.
        missed = (now - self.next) // self._period if self.next else 0
        self.next = (self.next or now) + (missed + 1) * self._period


def offer_services(node: Node, player: Player) -> None:
    """Offer ``~/pause``, ``~/resume``, ``~/step`` (one message) and ``~/step_sample``, all std_srvs/Trigger."""

    def serve(name: str, act: Callable[[], str]) -> None:
        def answer(request: Any, response: Any) -> Any:
            response.message = act()
            response.success = not player.ended
            return response

        node.create_service(Trigger, f"~/{name}", answer)

    def position() -> str:
        return f"bag time {player.position * 1e-9:.6f} s, {player.sent} messages sent"

    def pause() -> str:
        player.pause()
        return position()

    def resume() -> str:
        player.resume()
        return position()

    def step() -> str:
        return f"{player.step()} message, {position()}"

    def step_sample() -> str:
        return f"{player.step_sample()} messages, {position()}"

    for name, act in (("pause", pause), ("resume", resume), ("step", step), ("step_sample", step_sample)):
        serve(name, act)
