"""Where publish times leave the order open, the recorded outputs decide: an order that gives them is the right one.

The state of the node is kept now and then. When an output differs from the recorded one, the loose messages about the
last few acts are tried on their other side. If none of these orders gives the recorded output, the difference is one of
the code, or cannot be told from one: nothing more is tried.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, product
from typing import Any

from rclpy.serialization import deserialize_message

from dp_node import DpNode
from dp_tools.reexecution.canonical import canonical
from dp_tools.reexecution.detached import Wires
from dp_tools.reexecution.memento import Memento
from dp_tools.reexecution.order import Order
from dp_tools.reexecution.recording import Recorded

# No more orders than that are tried for one act. A second of setpoints may have been waiting for a simulator that stood
# still.
_LARGEST = 200


class State:
    """What a detached node is in the middle of.

    Parameters
    ----------
    node, wires
        The node, started.
    """

    def __init__(self, node: DpNode[Any], wires: Wires) -> None:
        self._node = node
        self._wires = wires

    def save(self) -> Memento:
        """Keep the state as it is."""
        node, wires = self._node, self._wires
        apart = [node, wires, *wires.mouths.values(), *wires.ears, *wires.timers, *wires.services.values()]
        own = {name: getattr(node, name) for name in wires.made_at_start}
        return _NodeMemento(node, own, apart)


class _NodeMemento(Memento):
    """A memento of what a node has made for its work."""

    def __init__(self, node: DpNode[Any], own: dict[str, Any], apart: Iterable[Any]) -> None:
        super().__init__(own.values(), apart)
        self._node, self._own = node, own

    def restore(self) -> None:
        """Go back to this state."""
        super().restore()
        vars(self._node).update(self._own)


@dataclass(frozen=True)
class Saved:
    """State before an act."""

    act: int
    state: Memento
    caught: int


class Matcher:
    """Tells whether what was caught is what was recorded, to the bit, as far as it goes."""

    def __init__(self, wires: Wires, recorded: Mapping[str, Sequence[Recorded]]) -> None:
        self._wires = wires
        self._recorded = recorded
        self._counts: dict[str, int] = {}
        self._looked = 0

    @property
    def caught(self) -> int:
        """Number of messages caught so far."""
        return len(self._wires.caught)

    def back_to(self, caught: int) -> None:
        """Forget what was caught after the first ``caught`` messages."""
        for one in self._wires.caught[caught : self._looked]:
            self._counts[one.topic] -= 1
        del self._wires.caught[caught:]
        self._looked = min(self._looked, caught)

    def matches(self) -> bool:
        """Look at what was caught since the last time; False at the first that is not as recorded."""
        same = True
        for one in self._wires.caught[self._looked :]:
            number = self._counts.get(one.topic, 0)
            self._counts[one.topic] = number + 1
            recorded = self._recorded.get(one.topic, ())
            # A topic that was not recorded tells nothing, nor does what came after the end of the recording.
            if same and number < len(recorded):
                same = (
                    canonical(deserialize_message(recorded[number].data, self._wires.mouths[one.topic].kind))
                    == one.form
                )
        self._looked = len(self._wires.caught)
        return same


def other_orders(order: Order[Any], act: int, topic_of: Any) -> Iterator[dict[int, int]]:
    """Yield other places for the loose messages that are unsure about ``act``: number of acts before each.

    Messages of one topic keep their order; those nearest to what holds now come first.
    """
    unsure = order.unsure(act)
    groups = [list(group) for _, group in groupby(sorted(unsure, key=lambda i: (topic_of(i), i)), key=topic_of)]
    cuts = [sum(order.place[i] <= act for i in group) for group in groups]
    choices = product(*(range(len(group) + 1) for group in groups))
    near = sorted(choices, key=lambda choice: sum(abs(a - b) for a, b in zip(choice, cuts, strict=True)))
    for choice in near[1 : _LARGEST + 1]:
        places = {}
        for group, cut in zip(groups, choice, strict=True):
            for number, i in enumerate(group):
                places[i] = act if number < cut else max(order.place[i], act + 1)
        yield places
