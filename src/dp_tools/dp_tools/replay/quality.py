"""Quality of service of a replayed topic: what its publishers had offered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

# Publishers do not tell their history to others, so most bags do not have it: as in the graph.
_DEPTH = 1000
_FOREVER = (1 << 63) - 1


def replayed_quality(offered: Sequence[Mapping[str, Any]]) -> QoSProfile:
    """Return the profile to replay with; the strictest of several, so that who heard one of them hears the replay.

    Parameters
    ----------
    offered
        One mapping a publisher as rosbag2 writes it, with words (version 9) or numbers (before). None, or one that
        makes no sense, counts as reliable and volatile.
    """
    reliable = [_policy(ReliabilityPolicy, one.get("reliability")) for one in offered]
    durable = [_policy(DurabilityPolicy, one.get("durability")) for one in offered]
    alive = [_policy(LivelinessPolicy, one.get("liveliness")) for one in offered]
    only_best_effort = bool(reliable) and all(policy == ReliabilityPolicy.BEST_EFFORT for policy in reliable)
    latched = DurabilityPolicy.TRANSIENT_LOCAL in durable
    manual = LivelinessPolicy.MANUAL_BY_TOPIC in alive
    keep_all = any(_policy(HistoryPolicy, one.get("history")) == HistoryPolicy.KEEP_ALL for one in offered)
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if keep_all else HistoryPolicy.KEEP_LAST,
        depth=max((_depth(one) for one in offered), default=_DEPTH),
        reliability=ReliabilityPolicy.BEST_EFFORT if only_best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        deadline=_shortest(offered, "deadline"),
        lifespan=_longest(offered, "lifespan"),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=_shortest(offered, "liveliness_lease_duration"),
    )


def _policy(kind: Any, value: Any) -> Any:
    """Return a policy by word or number; None for what is none."""
    try:
        return kind[value.upper()] if isinstance(value, str) else kind(value)
    except (KeyError, ValueError, TypeError):
        return None


def _depth(one: Mapping[str, Any]) -> int:
    depth = one.get("depth")
    told = _policy(HistoryPolicy, one.get("history")) == HistoryPolicy.KEEP_LAST
    return depth if told and type(depth) is int and 0 < depth <= 100_000 else _DEPTH


def _nanoseconds(one: Mapping[str, Any], name: str) -> int:
    """Return a duration; none, or one that makes no sense, is no limit."""
    value = one.get(name)
    if not isinstance(value, dict):
        return _FOREVER
    sec, nsec = value.get("sec"), value.get("nsec")
    if type(sec) is not int or type(nsec) is not int:
        return _FOREVER
    total = sec * 1_000_000_000 + nsec
    return total if 0 < total < _FOREVER else _FOREVER


def _shortest(offered: Sequence[Mapping[str, Any]], name: str) -> Duration:
    return Duration(nanoseconds=min((_nanoseconds(one, name) for one in offered), default=_FOREVER))


def _longest(offered: Sequence[Mapping[str, Any]], name: str) -> Duration:
    return Duration(nanoseconds=max((_nanoseconds(one, name) for one in offered), default=_FOREVER))
