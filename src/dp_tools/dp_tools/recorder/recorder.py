"""Subscriptions that follow the graph, drained into a bag."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from dp_bringup.message_types import MessageTypeError, message_class
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.quality import DEPTH, describe_quality, matching_quality
from dp_tools.recorder.schemas import DefinitionMissingError, full_definition
from dp_tools.recorder.selection import Selection
from dp_tools.recorder.sequence import SequenceCounter


@dataclass(slots=True)
class _Topic:
    name: str
    message_class: Any
    channel: int
    quality: QoSProfile
    subscription: Subscription
    sequence: SequenceCounter
    count: int = 0
    tap: Callable[[int, bytes], None] | None = None


def _never(message: bytes, info: dict[str, Any]) -> None:
    """Stand for the callback of a subscription that no executor serves."""


class Recorder:
    """Subscribes to topics as they appear and writes what they carry to a bag.

    Messages stay serialized. They wait in the middleware, thousands a topic, until :meth:`drain` takes them all: that
    costs a few microseconds a message, where a callback a message would cost a wake-up each. The time of reception is
    the middleware's, so it does not suffer.

    Parameters
    ----------
    node
        Subscribes here. No executor may spin it.
    writer
        The bag.
    selection
        Which topics to record.
    taps
        Called with publish time (ns) and data of every message of a topic, by its full name.
    """

    def __init__(
        self,
        node: Node,
        writer: BagWriter,
        selection: Selection,
        taps: Mapping[str, Callable[[int, bytes], None]] | None = None,
    ) -> None:
        self._node = node
        self._writer = writer
        self._selection = selection
        self._taps = taps or {}
        self._topics: dict[str, _Topic] = {}
        self._refused: set[str] = set()

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        return {name: topic.count for name, topic in self._topics.items()}

    @property
    def lost(self) -> dict[str, int]:
        """Messages known to be lost, by topic, where there are any."""
        return {name: topic.sequence.lost for name, topic in self._topics.items() if topic.sequence.lost}

    def discover(self) -> None:
        """Subscribe to topics that are new in the graph."""
        for name, kinds in self._node.get_topic_names_and_types():
            if name in self._topics or name in self._refused or not self._selection.wants(name):
                continue
            publishers = self._node.get_publishers_info_by_topic(name)
            if not publishers:
                continue  # somebody listens, nobody speaks yet
            if len(kinds) > 1:
                self._node.get_logger().warning(f"{name}: has types {', '.join(kinds)}; only {kinds[0]} is recorded")
            self._subscribe(name, kinds[0], publishers)

    def adapt(self) -> None:
        """Notice publishers that came to known topics: their number, and whether they offer less than was asked for."""
        for topic in self._topics.values():
            offered = [info.qos_profile for info in self._node.get_publishers_info_by_topic(topic.name)]
            if len(offered) > 1:
                topic.sequence.several_publishers()
            else:
                topic.sequence.one_publisher()
            # Only ever weaker: asking for more again would bring latched messages a second time.
            quality = matching_quality([*offered, topic.quality])
            if quality != topic.quality:
                self._drain(topic)
                self._node.destroy_subscription(topic.subscription)
                topic.quality = quality
                topic.subscription = self._node.create_subscription(
                    topic.message_class, topic.name, _never, quality, raw=True
                )

    def settle(self) -> None:
        """Look at the number of publishers for the last time, so that the gaps found last are counted or forgotten."""
        for topic in self._topics.values():
            several = self._node.count_publishers(topic.name) > 1
            for _ in range(2):
                if several:
                    topic.sequence.several_publishers()
                else:
                    topic.sequence.one_publisher()

    def drain(self) -> int:
        """Write everything that has arrived; return how many messages.

        Raises
        ------
        RecordingStoppedError
            If the bag cannot be written.
        """
        return sum(self._drain(topic) for topic in self._topics.values())

    def _drain(self, topic: _Topic) -> int:
        take, kind = topic.subscription.handle.take_message, topic.message_class
        write, channel, note = self._writer.write, topic.channel, topic.sequence.note
        tap = topic.tap
        count = 0
        while count < DEPTH and (taken := take(kind, True)) is not None:
            data, info = taken
            number = info["publication_sequence_number"]
            note(number)
            write(channel, data, info["received_timestamp"], info["source_timestamp"], number or 0)
            if tap is not None:
                tap(info["source_timestamp"], data)
            count += 1
        topic.count += count
        return count

    def _subscribe(self, name: str, kind: str, publishers: Sequence[Any]) -> None:
        try:
            found = message_class(kind)
            definition = full_definition(kind)
        except (MessageTypeError, DefinitionMissingError) as error:
            self._refused.add(name)
            self._node.get_logger().warning(f"{name}: not recorded: {error}")
            return
        offered = [info.qos_profile for info in publishers]
        quality = matching_quality(offered)
        # Subscribe first, describe after: messages may be on their way.
        subscription = self._node.create_subscription(found, name, _never, quality, raw=True)
        info = TopicInfo(
            name=name,
            kind=kind,
            type_hash=str(publishers[0].topic_type_hash),
            offered_quality=tuple(describe_quality(one) for one in offered),
        )
        channel = self._writer.add_topic(info, definition)
        topic = _Topic(name, found, channel, quality, subscription, SequenceCounter(), tap=self._taps.get(name))
        if len(publishers) > 1:
            topic.sequence.several_publishers()
        self._topics[name] = topic
