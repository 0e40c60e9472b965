"""Base class of the nodes that answer: observer, controller, allocator, drivers."""

from __future__ import annotations

from typing import Any, TypeVar

from dp_node.node import DpNode
from marine_model.settings import Settings

S = TypeVar("S", bound=Settings)


class RingNode(DpNode[S]):
    """A node of the ring, which can run in lockstep.

    In lockstep every message is sent once and somebody waits for the answer. At the start, one node may not have heard
    of another yet when it sends its first message; a synchronous node asks for what was sent before.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self.synchronous: bool = self.structural(
            "synchronous",
            False,
            "Lockstep: wait for everything that belongs to a sample, and lose nothing at the start",
        )

    @property
    def in_lockstep(self) -> bool:
        """Messages sent before this node was known as well, if synchronous."""
        return self.synchronous
