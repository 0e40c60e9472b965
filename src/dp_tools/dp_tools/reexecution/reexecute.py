"""One node of a bag, re-executed: the present code fed with what the recorded node was fed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from dp_msgs.msg import ActuatorSetpoint
from rclpy.serialization import deserialize_message

from dp_node import DpNode, to_nanoseconds
from dp_tools.node_settings import ALLOCATOR, CONTROLLER, DRIVERS, OBSERVER, SIMULATOR
from dp_tools.recorder.attachments import VESSEL_ATTACHMENT
from dp_tools.recorder.schemas import full_definition
from dp_tools.reexecution.breaks import Break, first_break, until
from dp_tools.reexecution.detached import Caught, detached_node
from dp_tools.reexecution.errors import ReexecutionError
from dp_tools.reexecution.evidence import Evidence, Node, evidence_of, in_process_evidence
from dp_tools.reexecution.feeder import Feeder
from dp_tools.reexecution.node_parameters import NodeParameters, node_parameters
from dp_tools.reexecution.order import merge
from dp_tools.reexecution.recording import Recorded, Recording
from dp_tools.reexecution.run import Progress, Run
from dp_tools.reexecution.stamps import stamp_of
from dp_tools.reexecution.trial import Matcher, State

# Simulated time over wall time: every step that the simulator is told to make is due at once.
_AT_ONCE = 1e9


@dataclass
class Subject:
    """What is re-executed.

    Parameters
    ----------
    recording
        The bag.
    namespace
        Of the graph in it, with a slash at its end.
    name
        Node.
    given
        Parameters that are set instead of the recorded ones.
    """

    recording: Recording
    namespace: str
    name: str
    given: Mapping[str, Any] = field(default_factory=dict)

    def messages(self, topic: str) -> Sequence[Recorded]:
        """Return the recorded messages of a topic (relative to the namespace)."""
        found = self.recording.topics.get(self.namespace + topic)
        return () if found is None else found.messages


@dataclass
class Reexecution:
    """What re-execution gave.

    Attributes
    ----------
    subject
        What was re-executed.
    outputs
        Messages by topic.
    kinds
        Message class by topic.
    class_name
        Of the node.
    steps
        Number of messages and changes that were fed.
    notes
        What the bag does not say for certain, and what the present code takes otherwise.
    moved
        How often the outputs told the order of inputs, where publish times leave it open.
    broken
        Where the node was restarted or deactivated: what came after was neither fed nor is it compared. None if it
        lived on to the end.
    begins
        Why the node had been running before the recording began; empty if it had not.
    """

    subject: Subject
    outputs: dict[str, list[Caught]]
    kinds: dict[str, Any]
    class_name: str
    steps: int
    notes: list[str]
    moved: int
    broken: Break | None = None
    begins: str = ""

    @property
    def types(self) -> dict[str, str]:
        """Message type by topic, e.g. ``nav_msgs/msg/Odometry``."""
        return {
            topic: "/".join((kind.__module__.split(".")[0], "msg", kind.__name__)) for topic, kind in self.kinds.items()
        }

    @property
    def simulated(self) -> float:
        """Simulated time from the first to the last output, s."""
        stamps = [stamp_of(one.data) for caught in self.outputs.values() for one in (*caught[:1], *caught[-1:])]
        return (max(stamps) - min(stamps)) * 1e-9 if stamps else 0.0


def reexecute(subject: Subject, progress: Progress = lambda done, of: None) -> Reexecution:
    """Feed a node with its recorded inputs and changes of parameters.

    Raises
    ------
    ReexecutionError
        If the bag lacks the node's outputs, its vessel file or its parameters.
    DpError
        If the node refuses to start.
    """
    broken = _break(subject)
    if broken is not None:
        outputs_of = [subject.namespace + topic for topic in OUTPUTS[subject.name]]
        subject = replace(subject, recording=until(subject.recording, broken, outputs_of))
    recording = subject.recording
    parameters = node_parameters(recording, subject.namespace, subject.name, subject.given)
    start = _start(subject, parameters)
    with _vessel_file(recording) as vessel, detached_node(subject.name, vessel, start, recording.start) as made:
        node, wires = made
        notes = [*parameters.notes, *_parameter_notes(node, subject, parameters)]
        kinds = {topic: mouth.kind for topic, mouth in wires.mouths.items()}
        evidence = _evidence(subject, list(kinds), parameters)
        _expect_present_definitions(subject, [*INPUTS[subject.name], *kinds])
        notes += _gap_notes(subject, [*INPUTS[subject.name], *kinds])
        order = merge(evidence.acts, evidence.loose)
        feeder = Feeder(subject.name, node, wires, bool(start.get("lockstep")))
        # A run in process and lockstep leave nothing open; with another setting the recorded outputs tell nothing.
        known = recording.in_process or start.get("synchronous") or start.get("lockstep") or subject.given
        recorded = {topic: subject.messages(topic) for topic in kinds}
        run = Run(order, feeder, Matcher(wires, recorded), None if known else State(node, wires))
        run.all(progress)
        feeder.end()
        class_name = type(node).__mro__[2].__name__
    outputs: dict[str, list[Caught]] = {topic: [] for topic in kinds}
    for caught in wires.caught:
        outputs[caught.topic].append(caught)
    notes += feeder.notes
    if run.moved:
        notes.append(f"{run.moved} times publish times left the order of inputs open, and the outputs told it")
    if run.gave_up is not None:
        notes.append(
            f"from input {run.gave_up} of {len(order.acts)} on, no order of inputs gives the recorded outputs; "
            "differences after the first may come from another order"
        )
    return Reexecution(
        subject, outputs, kinds, class_name, len(order), notes, run.moved, broken, _begins(subject, list(kinds))
    )


def _break(subject: Subject) -> Break | None:
    """Return where the node was restarted or deactivated; a run in process has neither."""
    if subject.recording.in_process:
        return None
    outputs = {topic: subject.messages(topic) for topic in OUTPUTS[subject.name]}
    return first_break(outputs, subject.messages(f"{subject.name}/transition_event"))


def _begins(subject: Subject, outputs: Sequence[str]) -> str:
    """Return of which output the first messages were not recorded; empty if all were."""
    for topic in outputs:
        first = next((message.number for message in subject.messages(topic)), 0)
        if first > 1:
            return f"the recording begins with message {first} of {topic}"
    return ""


def _parameter_notes(node: DpNode[Any], subject: Subject, parameters: NodeParameters) -> list[str]:
    """Return where the parameters of the present node are not those of the recorded one. Raises ReexecutionError."""
    unknown = [name for name in subject.given if not node.has_parameter(name)]
    if unknown:
        raise ReexecutionError(f"--set: {subject.name} has no parameter {unknown[0]}")
    gone = sorted(name for name in parameters.start if not node.has_parameter(name))
    return [f"the present {subject.name} has no parameter {', '.join(gone)}"] if gone else []


def _expect_present_definitions(subject: Subject, topics: Sequence[str]) -> None:
    """Raise ReexecutionError if a topic was recorded with another definition of its messages than the present one."""
    for topic in topics:
        found = subject.recording.topics.get(subject.namespace + topic)
        if found is not None and _fields(found.definition) != _fields(full_definition(found.kind)):
            raise ReexecutionError(
                f"{subject.recording.path}: {found.name}: expected messages {found.kind} as they are defined at "
                "present, found another definition of them: they cannot be fed"
            )


def _fields(definition: str) -> list[str]:
    """Return the lines of a definition without comments and spaces."""
    lines = ("".join(line.partition("#")[0].split()) for line in definition.splitlines())
    return [line for line in lines if line]


def _gap_notes(subject: Subject, topics: Sequence[str]) -> list[str]:
    """Return what is missing in the bag, by the numbers that publishers give their messages."""
    notes = []
    for topic in topics:
        numbers = [message.number for message in subject.messages(topic) if message.number]
        if not numbers:
            continue
        if numbers[0] > 1:
            notes.append(f"the recording begins with message {numbers[0]} of {topic}; what was before is not known")
        lost = sum(b - a - 1 for a, b in pairwise(numbers) if b > a)
        if lost:
            notes.append(f"{lost} messages of {topic} are missing in the bag, or another publisher was there")
    return notes


@contextmanager
def _vessel_file(recording: Recording) -> Iterator[Path]:
    attached = recording.attachment(VESSEL_ATTACHMENT)
    if attached is None:
        raise ReexecutionError(
            f"{recording.path}: expected the vessel it was recorded with, found no {VESSEL_ATTACHMENT}"
        )
    with TemporaryDirectory() as folder:
        path = Path(folder) / VESSEL_ATTACHMENT
        path.write_bytes(attached.data)
        yield path


def _start(subject: Subject, parameters: NodeParameters) -> dict[str, Any]:
    """Return start parameters; the simulator is told when to step."""
    start = {name: value for name, value in parameters.start.items() if name not in ("vessel", "autostart")}
    if subject.name == SIMULATOR:
        if subject.recording.in_process:
            # In process the step follows the drivers' answer, and nobody acknowledges commands.
            start["lockstep"] = False
        start["hold"] = True
        start["rate"] = 0.0 if start.get("lockstep") else _AT_ONCE
    return start


def _evidence(subject: Subject, outputs: Sequence[str], parameters: NodeParameters) -> Evidence:
    inputs = INPUTS[subject.name]
    node = Node(
        {topic: subject.messages(topic) for topic in inputs},
        {topic: subject.messages(topic) for topic in outputs},
        parameters.changes,
        _command_in_force,
    )
    if not any(node.outputs.values()):
        raise ReexecutionError(
            f"{subject.recording.path}: expected messages of {subject.name} ({', '.join(outputs)}), found none"
        )
    return (in_process_evidence if subject.recording.in_process else evidence_of)(subject.name, node)


# All that a node may listen to; to some it does only while a setting asks for them.
INPUTS: Mapping[str, tuple[str, ...]] = {
    OBSERVER: ("pose", "tau_achieved"),
    CONTROLLER: ("odometry", "tau_achieved", "setpoint", "joystick", "path", "wind"),
    ALLOCATOR: ("tau_desired", "thruster_feedback", "ventilation"),
    DRIVERS: ("thruster_feedback", "thruster_command", "odometry"),
    SIMULATOR: ("actuator_setpoint",),
}


# By these the life of a node is seen.
OUTPUTS: Mapping[str, tuple[str, ...]] = {
    OBSERVER: ("odometry", "observer_state"),
    CONTROLLER: ("tau_desired", "controller_status"),
    ALLOCATOR: ("thruster_command", "tau_achieved", "allocation_status"),
    DRIVERS: ("actuator_setpoint", "ventilation"),
    SIMULATOR: ("truth", "thruster_feedback", "clock"),
}


def _command_in_force(message: Recorded) -> int | None:
    setpoint = deserialize_message(message.data, ActuatorSetpoint)
    stamp = to_nanoseconds(setpoint.command_stamp)
    # Zero is also what stands there before the first command; thrust is held at zero for want of commands then.
    return None if stamp == 0 and setpoint.command_stale else stamp
