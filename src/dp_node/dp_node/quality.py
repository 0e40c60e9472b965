"""Quality of service of every topic in the graph, chosen in one place."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

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

# Operator inputs and states that a late joiner must still see.
LATCHED = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
