"""Which recorded message a node answered with which: what is known for certain about the order of its inputs."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from dp_tools.node_settings import ALLOCATOR, CONTROLLER, DRIVERS, OBSERVER, SIMULATOR
from dp_tools.reexecution.feed import Changed, Due, Heard, Item
from dp_tools.reexecution.order import Act, Loose
from dp_tools.reexecution.recording import Recorded
from dp_tools.reexecution.stamps import stamp_of

Messages = Sequence[Recorded]
_OPERATOR = ("setpoint", "joystick", "path")


@dataclass
class Evidence:
    """Inputs and changes of one node, sorted into acts and loose messages.

    Attributes
    ----------
    unheard
        Number of messages by topic that were published before the node answered its first, or after its last.
    early
        Number of an operator's messages by topic whose answers came before the recording of the answers began.
    """

    acts: list[Act[Item]] = field(default_factory=list)
    loose: list[Loose[Item]] = field(default_factory=list)
    unheard: dict[str, int] = field(default_factory=dict)
    early: dict[str, int] = field(default_factory=dict)

    def act(self, item: Item, published: int, answers: Sequence[Recorded]) -> None:
        """Add something with its answers, in the order in which they were published."""
        times = [answer.published for answer in answers] or [published]
        self.acts.append(Act(item, published, min(times), max(times)))


@dataclass(frozen=True)
class Node:
    """What a bag has of one node.

    Parameters
    ----------
    inputs, outputs
        Messages by topic, in order of publish time.
    changes
        Changes of parameters with the publish time (ns) of their events.
    command_in_force
        Returns the stamp (ns) of the command in force that an actuator_setpoint tells of, None before the first.
    """

    inputs: Mapping[str, Messages]
    outputs: Mapping[str, Messages]
    changes: Sequence[tuple[int, Changed]]
    command_in_force: Callable[[Recorded], int | None]


class _ByStamp:
    """Messages to be taken by stamp, each once, the oldest first."""

    def __init__(self, messages: Messages) -> None:
        self._waiting: dict[int, deque[int]] = defaultdict(deque)
        self._messages = messages
        for i, message in enumerate(messages):
            self._waiting[stamp_of(message.data)].append(i)
        self.taken: set[int] = set()

    def before(self, stamp: int, time: int) -> int | None:
        """Take the first of ``stamp`` if it was published before ``time``; return its number."""
        return self._take(stamp, lambda message: message.published <= time)

    def after(self, stamp: int, time: int) -> Recorded | None:
        """Take the first of ``stamp`` that was published after ``time``."""
        waiting = self._waiting.get(stamp)
        while waiting and self._messages[waiting[0]].published < time:
            waiting.popleft()
        number = self._take(stamp, lambda message: True)
        return None if number is None else self._messages[number]

    def _take(self, stamp: int, fits: Callable[[Recorded], bool]) -> int | None:
        waiting = self._waiting.get(stamp)
        if not waiting or not fits(self._messages[waiting[0]]):
            return None
        number = waiting.popleft()
        self.taken.add(number)
        return number


def evidence_of(name: str, node: Node) -> Evidence:
    """Return what the answers of node ``name`` say about the order of its inputs.

    A node that is not one of the ring's five has no known answers: all of its inputs are loose.
    """
    found = Evidence()
    for time, change in node.changes:
        found.act(change, time, ())
    rule = _RULES.get(name)
    used = rule(node, found) if rule is not None else {}
    for topic, messages in node.inputs.items():
        answered = used.get(topic)
        # What was published before the node heard anything was not heard; nor was what came after its last answer.
        first, last = (min(answered), max(answered)) if answered else (0, len(messages) - 1)
        first = 0 if found.early.get(topic) else first
        unheard = first + len(messages) - 1 - last
        if unheard and messages:
            found.unheard[topic] = unheard
        for i in range(first, last + 1):
            if answered is None or i not in answered:
                found.loose.append(Loose(Heard(topic, messages[i]), messages[i].published))
    return found


def _answered(node: Node, found: Evidence, topic: str, answers: Sequence[str]) -> tuple[dict[str, set[int]], Messages]:
    """Match the messages of ``topic`` with the first of ``answers`` by stamp.

    Returns which of them were answered, and the answers to nothing.
    """
    inputs = _ByStamp(node.inputs.get(topic, ()))
    others = [_ByStamp(node.outputs.get(answer, ())) for answer in answers[1:]]
    unasked = []
    for answer in node.outputs.get(answers[0], ()):
        stamp = stamp_of(answer.data)
        number = inputs.before(stamp, answer.published)
        rest = [one for one in (other.after(stamp, answer.published) for other in others) if one is not None]
        if number is None:
            unasked.append(answer)
            continue
        asked = node.inputs[topic][number]
        found.act(Heard(topic, asked), asked.published, [answer, *rest])
    return {topic: inputs.taken}, unasked


def _observer(node: Node, found: Evidence) -> dict[str, set[int]]:
    used, unasked = _answered(node, found, "pose", ("odometry", "observer_state"))
    for answer in unasked:  # the watchdog went on without a pose
        found.act(Due(stamp_of(answer.data)), answer.published, [answer])
    return used


def _allocator(node: Node, found: Evidence) -> dict[str, set[int]]:
    return _answered(node, found, "tau_desired", ("thruster_command", "tau_achieved", "allocation_status"))[0]


def _controller(node: Node, found: Evidence) -> dict[str, set[int]]:
    used, _ = _answered(node, found, "odometry", ("tau_desired",))
    # A status comes with every demand, after every change of parameters, and with every input of an operator.
    statuses = node.outputs.get("controller_status", ())
    own = _ByStamp(statuses)
    for demand in node.outputs.get("tau_desired", ()):
        own.after(stamp_of(demand.data), demand.published)
    free = [status for i, status in enumerate(statuses) if i not in own.taken]
    spoken = sorted(one.published for one in (*node.outputs.get("tau_desired", ()), *statuses))
    for time, _change in node.changes:
        answer = next((status for status in free if status.published >= time), None)
        # Nothing else is said before the answer: one that was not recorded must not take that of a set point.
        if answer is not None and answer.published == spoken[bisect_left(spoken, time)]:
            free.remove(answer)
    asked = sorted(
        ((message.published, topic, i) for topic in _OPERATOR for i, message in enumerate(node.inputs.get(topic, ())))
    )
    for status in free:
        stamp = stamp_of(status.data)
        for published, topic, i in asked:
            message = node.inputs[topic][i]
            # A stamp of zero is answered with that of the last odometry.
            if published <= status.published and stamp_of(message.data) in (stamp, 0):
                found.act(Heard(topic, message), published, [status])
                used.setdefault(topic, set()).add(i)
                asked.remove((published, topic, i))
                break
    if statuses and statuses[0].number > 1:
        # The recording missed the first answers: what they answered was heard all the same.
        for topic in used.keys() & set(_OPERATOR):
            found.early[topic] = sum(one.published < statuses[0].published for one in node.inputs[topic])
    return used


def _drivers(node: Node, found: Evidence) -> dict[str, set[int]]:
    feedback, commands = (
        _ByStamp(node.inputs.get("thruster_feedback", ())),
        _ByStamp(node.inputs.get("thruster_command", ())),
    )
    ventilation = _ByStamp(node.outputs.get("ventilation", ()))
    in_force: int | None = None
    for answer in node.outputs.get("actuator_setpoint", ()):
        stamp, command = stamp_of(answer.data), node.command_in_force(answer)
        # A command is acknowledged at once: the first set point that tells of it answers it.
        new = command is not None and command != in_force and command == stamp
        in_force = in_force if command is None else command
        number = commands.before(stamp, answer.published) if new else None
        if number is not None:
            message = node.inputs["thruster_command"][number]
            found.act(Heard("thruster_command", message), message.published, [answer])
            continue
        number = feedback.before(stamp, answer.published)
        if number is not None:
            message = node.inputs["thruster_feedback"][number]
            other = ventilation.after(stamp, answer.published)
            rest = [] if other is None else [other]
            found.act(Heard("thruster_feedback", message), message.published, [answer, *rest])
    return {"thruster_feedback": feedback.taken, "thruster_command": commands.taken}


def _simulator(node: Node, found: Evidence) -> dict[str, set[int]]:
    truths, clocks = _ByStamp(node.outputs.get("truth", ())), _ByStamp(node.outputs.get("clock", ()))
    feedback = node.outputs.get("thruster_feedback", ())
    for i, message in enumerate(feedback):
        stamp = stamp_of(message.data)
        number = truths.before(stamp, message.published)
        first = message if number is None else node.outputs["truth"][number]
        # The step ends with the next stamp on the clock.
        following = stamp_of(feedback[i + 1].data) if i + 1 < len(feedback) else None
        end = clocks.after(following, message.published) if following is not None else None
        found.act(Due(stamp), first.published, [first, message, *([end] if end is not None else [])])
    return {}


_RULES: Mapping[str, Callable[[Node, Evidence], dict[str, set[int]]]] = {
    OBSERVER: _observer,
    CONTROLLER: _controller,
    ALLOCATOR: _allocator,
    DRIVERS: _drivers,
    SIMULATOR: _simulator,
}


def in_process_evidence(name: str, node: Node) -> Evidence:
    """Return the order of a run in process: that of the publish times, which follow the order of the calls.

    The simulator steps on the answer to its own feedback, so that its inputs come before the step of their stamp.
    """
    found = Evidence()
    for time, change in node.changes:
        found.act(change, time, ())
    first: dict[int, int] = {}
    if name == SIMULATOR:
        for topic in ("truth", "thruster_feedback"):
            for message in node.outputs.get(topic, ()):
                stamp = stamp_of(message.data)
                first.setdefault(stamp, message.published)
                if topic == "thruster_feedback":
                    found.act(Due(stamp), first[stamp], ())
    for topic, messages in node.inputs.items():
        for message in messages:
            time = first.get(stamp_of(message.data), message.published + 1) - 1
            found.act(Heard(topic, message), time, ())
    return found
