"""What every node says of itself on /diagnostics, whatever its core does: a pure function of a few counts."""

from __future__ import annotations

from dataclasses import dataclass

from dp_node.alarms import Alarm, raised
from dp_node.health import Health, health_with


@dataclass(frozen=True, slots=True)
class NodeCounts:
    """What a node knows of itself.

    Attributes
    ----------
    state
        Label of its life cycle.
    refused, fresh_refused
        Inputs refused since the start and since the last report.
    last_refusal
        Why the last one was refused.
    ignored
        Messages that came while the node was not active.
    refused_of_others
        Messages that were not those of the one publisher that a topic has by design.
    topics
        Alarms of its topics.
    """

    state: str
    refused: int
    fresh_refused: int
    last_refusal: str
    ignored: int
    refused_of_others: int = 0
    topics: tuple[Alarm, ...] = ()


def health_of(counts: NodeCounts, core: Health) -> Health:
    """Return the health of a node whose core says ``core``: of one that is not active only the values count."""
    values: dict[str, object] = {
        **core.values,
        "state": counts.state,
        "refused_inputs": counts.refused,
        "ignored_inputs": counts.ignored,
        "last_refusal": counts.last_refusal,
        "refused_of_others": counts.refused_of_others,
    }
    own: list[Alarm] = []
    active = counts.state == "active"
    if not active:
        own.append(raised("NODE-NOT-ACTIVE", counts.state))
    if counts.fresh_refused:
        own.append(raised("NODE-INPUT-REFUSED", counts.last_refusal))
    own += counts.topics
    mine = health_with(own, values)
    return core.worse_of(mine) if active else mine
