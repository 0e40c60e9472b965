"""Quality of service of every topic in the graph, chosen in one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from marine_model.errors import InputError

# A publisher drops its oldest message once this many are not acknowledged, reliable or not. In lockstep a topic carries
# over a thousand messages a second, and a recorder outside the ring may not get a processor for tens of milliseconds:
# with 50, recordings of composed runs on a busy machine lacked up to a thousand messages of a topic; with 1000, none.
_DEPTH = 1000

# Data that travels round the ring: nothing may be lost, and a late reader does not want old samples.
RING = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=_DEPTH,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
)

# The sending side keeps what it sent last for the one reader that does want it: a recorder that is still being
# matched when the first messages go out asks for transient-local durability and so loses none of them.
RING_PUBLISHER = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=_DEPTH,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)

# The listening side in lockstep: one message that is sent before its reader is matched, and the ring stands still.
RING_LOCKSTEP = RING_PUBLISHER

# Reports once a second: a late reader wants the last one. What a publisher keeps, it holds in memory: with the depth of
# the ring a node grew for the first thousand seconds.
REPORTS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=10,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)

# Within this time the process of every publisher of ours shows that it lives, messages or not. A shorter one would take
# a process that did not get a processor for dead.
OFFERED_LEASE = 2.0  # s


@dataclass(frozen=True, slots=True)
class TopicQuality:
    """What is agreed for a topic.

    Attributes
    ----------
    publish
        How our nodes publish it.
    volatile
        Whether it is heard volatile in lockstep too: whoever operates may publish so, and would not be heard otherwise.
    ours
        Whether only nodes of this graph publish it. Of these a reader may ask for a lease and a deadline, which a
        publisher with default settings offers not: real hardware, an operator and a player of bags would not be heard.
    """

    publish: QoSProfile
    volatile: bool = False
    ours: bool = False


_OURS = TopicQuality(RING_PUBLISHER, ours=True)
_HARDWARE = TopicQuality(RING_PUBLISHER)
_OPERATOR = TopicQuality(RING_PUBLISHER, volatile=True)
_TOLD = TopicQuality(RING_PUBLISHER)

TOPICS: Mapping[str, TopicQuality] = MappingProxyType(
    {
        # round the ring
        "odometry": _OURS,
        "tau_desired": _OURS,
        "tau_achieved": _OURS,
        "thruster_command": _OURS,
        "ventilation": _OURS,
        # between the ring and the vessel, real or simulated
        "pose": _HARDWARE,
        "wind": _HARDWARE,
        "thruster_feedback": _HARDWARE,
        "actuator_setpoint": _HARDWARE,
        # from whoever operates
        "setpoint": _OPERATOR,
        "joystick": _OPERATOR,
        "path": _OPERATOR,
        # for who looks on
        "observer_state": _TOLD,
        "controller_status": _TOLD,
        "allocation_status": _TOLD,
        "clock": _TOLD,
        "truth": _TOLD,
        "environment_force": _TOLD,
        "propulsion_truth": _TOLD,
        "/diagnostics": TopicQuality(REPORTS),
    }
)


@dataclass(frozen=True, slots=True)
class Promise:
    """What readers ask of the nodes of this graph; 0 for nothing.

    Attributes
    ----------
    lease
        Wall time in which the process of a publisher has to show that it lives, s.
    deadline
        Wall time in which messages of a topic have to follow each other, s. Publishers offer it too.

    Raises
    ------
    InputError
        If a time is negative, or the lease is shorter than what publishers offer.
    """

    lease: float = 0.0
    deadline: float = 0.0

    def __post_init__(self) -> None:
        if not (self.lease == 0.0 or OFFERED_LEASE <= self.lease < float("inf")):
            raise InputError(
                f"input_lease: expected 0 or at least {OFFERED_LEASE} s, which publishers offer, found {self.lease}"
            )
        if not 0.0 <= self.deadline < float("inf"):
            raise InputError(f"input_deadline: expected 0 or more seconds, found {self.deadline}")


def quality_of(topic: str) -> TopicQuality:
    """Return what is agreed for ``topic``; one that is not in the table is for who looks on."""
    return TOPICS.get(topic, _TOLD)


def offered(topic: str, promise: Promise) -> QoSProfile:
    """Return how a node of ours publishes ``topic``: alive within the lease, and within a deadline if there is one."""
    agreed = quality_of(topic)
    deadline = promise.deadline if agreed.ours else 0.0
    return _with(agreed.publish, OFFERED_LEASE, deadline)


def requested(topic: str, lockstep: bool, promise: Promise) -> QoSProfile:
    """Return how a node of ours listens to ``topic``."""
    agreed = quality_of(topic)
    base = RING_LOCKSTEP if lockstep and not agreed.volatile else RING
    return _with(base, promise.lease, promise.deadline) if agreed.ours else base


def _with(base: QoSProfile, lease: float, deadline: float) -> QoSProfile:
    """Return ``base`` with a lease and a deadline (s), where they are above 0."""
    made = QoSProfile(history=base.history, depth=base.depth, reliability=base.reliability, durability=base.durability)
    if lease > 0.0:
        made.liveliness = LivelinessPolicy.AUTOMATIC
        made.liveliness_lease_duration = Duration(seconds=lease)
    if deadline > 0.0:
        made.deadline = Duration(seconds=deadline)
    return made
