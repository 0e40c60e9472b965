"""The last messages of publishers that are about to go."""

from __future__ import annotations

import time
from collections.abc import Iterable

from rclpy.duration import Duration
from rclpy.publisher import Publisher

# A reader asks for what it has missed when a heartbeat tells of it, and Fast DDS sends one every 3 s.
PATIENCE = 4.0


def hand_over(publishers: Iterable[Publisher], patience: float = PATIENCE) -> bool:
    """Wait until every reader has acknowledged what was published; return False if one has not within ``patience`` (s).

    A reader that was killed never does, on any topic: so the time is one for all publishers.
    """
    deadline = time.monotonic() + patience
    everything = True
    for publisher in publishers:
        everything &= publisher.wait_for_all_acked(_left(deadline))
    return everything


def _left(deadline: float) -> Duration:
    return Duration(seconds=max(0.0, deadline - time.monotonic()))
