"""What is in a bag, message by message, as it was sent."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from dp_tools.bag_reader import bag_file, read_bag
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
    graph, loop = recorded.run, ClosedLoop(recorded.vessel, recorded.scenario).run()
    found = {}
    for name in sorted(set(graph.series) | set(loop.series)):
        if name not in graph or name not in loop or graph[name].values.shape != loop[name].values.shape:
            found[name] = float("inf")
            continue
        values = np.abs(graph[name].values - loop[name].values)
        # A lost pose is NaN in both.
        both = np.isnan(graph[name].values) & np.isnan(loop[name].values)
        found[name] = float(np.where(both, 0.0, values).max(initial=0.0))
        found[f"{name} time"] = float(np.abs(graph[name].t - loop[name].t).max(initial=0.0))
    for name in sorted(set(graph.labels) | set(loop.labels)):
        same = name in graph.labels and name in loop.labels and graph.labels[name].words == loop.labels[name].words
        found[f"{name} words"] = 0.0 if same else float("inf")
    return found
