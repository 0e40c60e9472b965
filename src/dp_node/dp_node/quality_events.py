"""What the middleware tells of a node's topics: who does not fit, who is silent, who is gone, what was lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import qos_policy_name_from_kind

from dp_node.alarms import Alarm, raised


@dataclass(slots=True)
class TopicEvents:
    """What is known of one end of one topic.

    Attributes
    ----------
    topic
        Its name.
    policy
        Last policy in which a peer did not fit; empty if all do.
    misfits
        Peers that are there and do not fit.
    alive, seen_alive
        Publishers that show that they live, and whether there ever was one; None if nobody asked for it.
    missed, lost
        Deadlines missed and messages lost since the last report.
    """

    topic: str
    policy: str = ""
    misfits: int = 0
    alive: int | None = None
    seen_alive: bool = False
    missed: int = 0
    lost: int = 0


def alarms_of(events: TopicEvents) -> Iterator[Alarm]:
    """Give the alarms that a topic's events mean."""
    if events.misfits > 0:
        policy = events.policy.lower() or "unknown policy"
        yield raised("NODE-QOS-INCOMPATIBLE", f"{events.topic}, {policy}, {events.misfits} of its ends")
    if events.seen_alive and events.alive == 0:
        yield raised("NODE-LIVELINESS-LOST", events.topic)
    if events.missed > 0:
        yield raised("NODE-DEADLINE-MISSED", f"{events.topic}, {events.missed} times")
    if events.lost > 0:
        yield raised("NODE-MESSAGES-LOST", f"{events.topic}, {events.lost}")


class QualityEvents:
    """Collects the events of all topics of a node between two reports."""

    def __init__(self) -> None:
        self._ends: list[tuple[TopicEvents, Callable[[], int]]] = []

    def subscription(self, topic: str, misfits: Callable[[], int]) -> SubscriptionEventCallbacks:
        """Return the callbacks for a new subscription; ``misfits`` counts the publishers that do not fit it."""
        events = self._add(topic, misfits)

        def liveliness(info: Any) -> None:
            events.alive = info.alive_count
            events.seen_alive = events.seen_alive or info.alive_count > 0

        def deadline(info: Any) -> None:
            events.missed += info.total_count_change

        def lost(info: Any) -> None:
            events.lost += info.total_count_change

        return SubscriptionEventCallbacks(
            deadline=deadline, incompatible_qos=_policy(events), liveliness=liveliness, message_lost=lost
        )

    def publisher(self, topic: str, misfits: Callable[[], int]) -> PublisherEventCallbacks:
        """Return the callbacks for a new publisher; ``misfits`` counts the subscriptions that do not fit it."""
        return PublisherEventCallbacks(incompatible_qos=_policy(self._add(topic, misfits)))

    def forget(self) -> None:
        """Forget all topics: their ends are given back."""
        self._ends.clear()

    def report(self) -> list[Alarm]:
        """Return what is the matter, and begin the next report."""
        found: list[Alarm] = []
        for events, misfits in self._ends:
            # The event says that somebody came who does not fit; the graph says whether he is still there.
            events.misfits = misfits() if events.policy else 0
            found += alarms_of(events)
            events.missed = events.lost = 0
        return found

    def _add(self, topic: str, misfits: Callable[[], int]) -> TopicEvents:
        events = TopicEvents(topic)
        self._ends.append((events, misfits))
        return events


def _policy(events: TopicEvents) -> Callable[[Any], None]:
    def incompatible(info: Any) -> None:
        events.policy = qos_policy_name_from_kind(info.last_policy_kind)

    return incompatible
