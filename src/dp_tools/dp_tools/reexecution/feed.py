"""What a node can be fed: messages, changes of parameters, and the time at which it acts by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dp_tools.reexecution.recording import Recorded


@dataclass(frozen=True, slots=True)
class Heard:
    """A message of ``topic`` (relative to the graph's namespace)."""

    topic: str
    message: Recorded


@dataclass(frozen=True, slots=True)
class Changed:
    """Parameters that the node took over together: rcl_interfaces/msg/Parameter."""

    parameters: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Due:
    """A moment at which the node acted without a message: the simulator's step at ``stamp``, the observer's watchdog.

    Parameters
    ----------
    stamp
        Simulated time of what it then published, ns.
    """

    stamp: int


Item = Heard | Changed | Due
