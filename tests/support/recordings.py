"""What is in a bag, message by message, as it was sent."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from mcap.reader import make_reader

from dp_tools.bag_reader import bag_file, read_bag
from dp_tools.campaign.comparison import differences
from dp_tools.in_process import ClosedLoop

# They carry wall-clock time, or begin before the recorder does (transition_event, which rclpy keeps for nobody).
_NOT_REPEATABLE = ("diagnostics", "rosout", "parameter_events", "transition_event")


def repeatable(topics: Iterable[str]) -> list[str]:
    """Return the topics whose content lockstep fixes to the bit."""
    return sorted(topic for topic in topics if topic.rpartition("/")[2] not in _NOT_REPEATABLE)


def messages_by_topic(bag: Path) -> dict[str, list[bytes]]:
    """Return serialized messages by topic, in the order in which each topic's publisher sent them."""
    found: dict[str, list[bytes]] = defaultdict(list)
    with bag_file(bag).open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            found[channel.topic].append(message.data)
    return dict(found)


def publication_numbers(bag: Path) -> dict[str, list[int]]:
    """Return the publishers' sequence numbers by topic."""
    found: dict[str, list[int]] = defaultdict(list)
    with bag_file(bag).open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            found[channel.topic].append(message.sequence)
    return dict(found)


def differences_from_in_process_loop(bag: Path) -> dict[str, float]:
    """Sail the bag's scenario in process; return the largest difference by series, infinite where a series lacks."""
    recorded = read_bag(bag)
    assert recorded.scenario is not None
    return differences(recorded.run, ClosedLoop(recorded.vessel, recorded.scenario).run())
