"""`dp topics`: what is published in the graph."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass
from typing import Annotated

import typer
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rich.table import Table

from dp_bringup.graph_nodes import ANNOUNCEMENT_SECONDS
from dp_bringup.message_types import message_class
from dp_bringup.operator_node import NoAnswerError, Operator, operator
from dp_tools.commands.root import Namespace, console
from dp_tools.recorder import RECORDER_EARS

_HIDDEN = ("/rosout", "/parameter_events", "/transition_event")  # ends of names


def topics(
    rate: Annotated[
        float, typer.Option(metavar="SECONDS", help="Listen for so many seconds and show messages a second.", min=0.0)
    ] = 0.0,
    every: Annotated[
        bool, typer.Option("--all", metavar="", help="Show rosout, parameter and life-cycle events as well.")
    ] = False,
    namespace: Namespace = "",
) -> None:
    """List topics with type, publishers and subscribers; in a namespace only those below it."""
    with operator(namespace) as one:
        # Nobody knows how many processes there are: each has had its turn once this has passed without news.
        found = one.settled(lambda: _visible(one.node, every), ANNOUNCEMENT_SECONDS, 3.0 * ANNOUNCEMENT_SECONDS)
        if not found:
            raise NoAnswerError(f"no topics below {one.node.get_namespace()}; is the graph running?")
        counts = _count(one, found, rate) if rate else Counter()
    table = Table()
    table.add_column("topic", no_wrap=True)
    table.add_column("type", overflow="fold")
    table.add_column("from → to", overflow="fold")
    if rate:
        table.add_column("Hz", justify="right")
    for topic in found:
        way = f"{', '.join(topic.senders)} → {', '.join(topic.listeners) or '–'}"
        hertz = [f"{counts[topic.name] / rate:.1f}"] if rate else []
        table.add_row(topic.name, topic.kind.replace("/msg/", "/"), way, *hertz)
    console.print(table)


@dataclass(frozen=True)
class _Topic:
    name: str
    kind: str
    senders: tuple[str, ...]
    listeners: tuple[str, ...]


def _visible(node: Node, every: bool) -> list[_Topic]:
    below = node.get_namespace().rstrip("/") + "/"
    found = []
    for name, kinds in sorted(node.get_topic_names_and_types()):
        if not name.startswith(below) or (name.endswith(_HIDDEN) and not every):
            continue
        senders, listeners = (
            tuple(sorted({_shown(end.node_name) for end in ends} - {node.get_name()}))
            for ends in (node.get_publishers_info_by_topic(name), node.get_subscriptions_info_by_topic(name))
        )
        if senders:
            found.append(_Topic(name, kinds[0], senders, listeners))
    return found


def _shown(node: str) -> str:
    return "recorder" if node == RECORDER_EARS else node


def _count(one: Operator, topics: list[_Topic], seconds: float) -> Counter[str]:
    """Return the number of messages on each topic within ``seconds``."""
    counts: Counter[str] = Counter()
    # A bare count: no decoding, and nobody is made to wait for us.
    quality = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    for topic in topics:
        one.node.create_subscription(
            message_class(topic.kind), topic.name, lambda raw, name=topic.name: counts.update([name]), quality, raw=True
        )
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        one.executor.spin_once(timeout_sec=0.05)
    return counts
