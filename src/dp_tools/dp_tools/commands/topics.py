"""`dp topics`: what is published in the graph."""

from __future__ import annotations

import time
from collections import Counter
from typing import Annotated, Any

import typer
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rich.table import Table

from dp_tools.commands.root import Namespace, console
from dp_tools.message_types import message_class
from dp_tools.operator_node import operator
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
        own = one.node.get_name()
        one.wait_until(lambda: any(t for t, _ in _visible(one.node, every)), 3.0, "a topic; is the graph running?")
        found = one.settled(lambda: _visible(one.node, every))
        counts: Counter[str] = Counter()
        if rate > 0.0:
            for topic, kind in found:
                # A bare count: no decoding, and nobody is made to wait for us.
                quality = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
                one.node.create_subscription(
                    message_class(kind), topic, lambda raw, topic=topic: counts.update([topic]), quality, raw=True
                )
            end = time.monotonic() + rate
            while time.monotonic() < end:
                one.executor.spin_once(timeout_sec=0.05)
        table = Table()
        table.add_column("topic", no_wrap=True)
        table.add_column("type", overflow="fold")
        table.add_column("from → to", overflow="fold")
        if rate:
            table.add_column("Hz", justify="right")
        for topic, kind in found:
            senders = _names(one.node.get_publishers_info_by_topic(topic))
            listeners = _names(one.node.get_subscriptions_info_by_topic(topic)) - {own}
            way = f"{', '.join(sorted(senders))} → {', '.join(sorted(listeners)) or '–'}"
            table.add_row(topic, kind.replace("/msg/", "/"), way, *([f"{counts[topic] / rate:.1f}"] if rate else []))
        console.print(table)


def _names(ends: list[Any]) -> set[str]:
    return {"recorder" if end.node_name == RECORDER_EARS else end.node_name for end in ends}


def _visible(node: Node, every: bool) -> list[tuple[str, str]]:
    below = node.get_namespace().rstrip("/") + "/"
    return [
        (topic, kinds[0])
        for topic, kinds in sorted(node.get_topic_names_and_types())
        if topic.startswith(below)
        and (every or not topic.endswith(_HIDDEN))
        and any(e.node_name != node.get_name() for e in node.get_publishers_info_by_topic(topic))
    ]
