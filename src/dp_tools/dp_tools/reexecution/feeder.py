"""Hands items to a detached node."""

from __future__ import annotations

from typing import Any

from dp_msgs.srv import Advance
from rclpy.parameter import Parameter

from dp_node import DpNode
from dp_tools.node_settings import SIMULATOR
from dp_tools.reexecution.detached import Ear, Wires
from dp_tools.reexecution.feed import Changed, Due, Heard, Item
from dp_tools.reexecution.recording import Recorded

# The simulator looks at the graph until it has seen it complete this many times; more do no harm.
_LOOKS = 5
# Causes that are no messages.
CHANGE, ITSELF, END = "a change of parameters", "itself", "the end"


class Feeder:
    """Hands items to a detached node.

    Parameters
    ----------
    name
        Of the node.
    node, wires
        The node, started.
    lockstep
        Whether it is a simulator in lockstep.

    Attributes
    ----------
    notes
        What the present code took otherwise than the recorded one.
    """

    def __init__(self, name: str, node: DpNode[Any], wires: Wires, lockstep: bool) -> None:
        self._name = name
        self._node = node
        self._wires = wires
        self._lockstep = lockstep
        self._ears: dict[str, list[Ear]] = {}
        self._past: dict[str, list[Recorded]] = {}
        self._known = -1
        self.notes: list[str] = []
        if name == SIMULATOR:
            for _ in range(_LOOKS):
                self._ring()

    def feed(self, item: Item, time: int) -> None:
        """Feed one item at ``time`` (ns) of the node's clock."""
        self._wires.time = time
        if isinstance(item, Heard):
            self._wires.cause = item.topic
            self._past.setdefault(item.topic, []).append(item.message)
            for ear in self._hearing(item.topic):
                ear.hear(item.message)
        elif isinstance(item, Changed):
            self._wires.cause = CHANGE
            result = self._node.set_parameters_atomically([Parameter.from_parameter_msg(p) for p in item.parameters])
            if not result.successful:
                names = ", ".join(p.name for p in item.parameters)
                self.notes.append(f"a recorded change of {names} is refused now: {result.reason}")
            self._tell_history()
        elif isinstance(item, Due):
            self._wires.cause = ITSELF
            self._act(item)

    def end(self) -> None:
        """Let the node say what it says on its way out, as on the graph when it is stopped."""
        self._wires.cause = END
        self._node.trigger_shutdown()

    def _act(self, due: Due) -> None:
        if self._name != SIMULATOR:
            self._ring()
            return
        vessel = self._node.vessel
        until = due.stamp * 1e-9 + vessel.simulation.time_step
        answer: list[Advance.Response] = []
        service = self._wires.services["~/advance"]
        service.send_response(Advance.Request(until=until), answer.append)
        if not self._lockstep:
            self._ring()

    def _ring(self) -> None:
        """Let every timer act that the node made for its work."""
        for timer in self._wires.timers[self._wires.scaffolding :]:
            timer.callback()

    def _hearing(self, topic: str) -> list[Ear]:
        if len(self._wires.ears) != self._known:
            self._known = len(self._wires.ears)
            self._ears = {}
            for ear in self._wires.ears:
                self._ears.setdefault(ear.topic, []).append(ear)
        return self._ears.get(topic, [])

    def _tell_history(self) -> None:
        """Tell a subscription that came with a change what was published before, if it asked for that."""
        for ear in self._wires.ears[max(self._known, 0) :]:
            if ear.wants_history:
                for message in self._past.get(ear.topic, [])[-ear.quality.depth :]:
                    ear.hear(message)
