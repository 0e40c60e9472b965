"""One node of a bag, re-executed: the present code fed with what the recorded node was fed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from dp_msgs.msg import ActuatorSetpoint
from rclpy.serialization import deserialize_message

from dp_node import to_nanoseconds
from dp_tools.node_settings import SIMULATOR
from dp_tools.recorder.attachments import VESSEL_ATTACHMENT
from dp_tools.reexecution.detached import Caught, detached_node
from dp_tools.reexecution.errors import ReexecutionError
from dp_tools.reexecution.evidence import Evidence, Node, evidence_of, in_process_evidence
from dp_tools.reexecution.feeder import Feeder
from dp_tools.reexecution.node_parameters import NodeParameters, node_parameters
from dp_tools.reexecution.order import Order, merge
from dp_tools.reexecution.recording import Recorded, Recording
from dp_tools.reexecution.run import Progress, Run
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
    order
        In which inputs were fed.
    steps
        How many.
    notes
        What the bag did not say for certain.
    """

    subject: Subject
    outputs: dict[str, list[Caught]]
    kinds: dict[str, Any]
    order: Order[Any]
    steps: int
    notes: list[str]


def reexecute(subject: Subject, progress: Progress = lambda done, of: None) -> Reexecution:
    """Feed a node with its recorded inputs and changes of parameters.

    Raises
    ------
    ReexecutionError
        If the bag lacks the node's outputs, its vessel file or its parameters.
    DpError
        If the node refuses to start.
    """
    recording = subject.recording
    parameters = node_parameters(recording, subject.namespace, subject.name, subject.given)
    with _vessel_file(recording) as vessel:
        start = _start(subject, parameters)
        with detached_node(subject.name, vessel, start, recording.start) as (node, wires):
            kinds = {topic: mouth.kind for topic, mouth in wires.mouths.items()}
            evidence = _evidence(subject, list(kinds), parameters)
            order = merge(evidence.acts, evidence.loose)
            feeder = Feeder(subject.name, node, wires, bool(start.get("lockstep")))
            known = subject.recording.in_process or start.get("synchronous") or start.get("lockstep")
            recorded = {topic: subject.messages(topic) for topic in kinds}
            run = Run(order, feeder, Matcher(wires, recorded), None if known else State(node, wires))
            run.all(progress)
            feeder.end()
    outputs: dict[str, list[Caught]] = {topic: [] for topic in kinds}
    for caught in wires.caught:
        outputs[caught.topic].append(caught)
    notes = parameters.notes + feeder.notes
    if run.moved:
        notes.append(f"where publish times leave the order open, the outputs told it: {run.moved} times")
    if run.gave_up is not None:
        notes.append(
            f"from step {run.gave_up} of {len(order.acts)} on, no order of the inputs gives the recorded outputs"
        )
    return Reexecution(subject, outputs, kinds, order, len(order), notes)


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
    inputs = _INPUTS.get(subject.name, ())
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


_INPUTS: Mapping[str, tuple[str, ...]] = {
    "dp_observer": ("pose", "tau_achieved"),
    "dp_controller": ("odometry", "tau_achieved", "setpoint", "joystick", "path", "wind"),
    "thrust_allocator": ("tau_desired", "thruster_feedback", "ventilation"),
    "thruster_drivers": ("thruster_feedback", "thruster_command"),
    "vessel_sim": ("actuator_setpoint",),
}


def _command_in_force(message: Recorded) -> int | None:
    setpoint = deserialize_message(message.data, ActuatorSetpoint)
    stamp = to_nanoseconds(setpoint.command_stamp)
    # Zero is also what stands there before the first command; thrust is held at zero for want of commands then.
    return None if stamp == 0 and setpoint.command_stale else stamp
