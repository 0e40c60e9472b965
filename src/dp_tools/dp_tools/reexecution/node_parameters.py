"""Parameters of a recorded node: with which it was started, and every change, out of the bag alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import parameter_value_to_python
from rclpy.serialization import deserialize_message

from dp_bringup.parameter_file import read_parameter_file
from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, parameters_attachment
from dp_tools.reexecution.errors import ReexecutionError
from dp_tools.reexecution.feed import Changed
from dp_tools.reexecution.recording import Recording
from dp_tools.reexecution.stamps import stamp_of

_EVENTS = "/parameter_events"
# They say how fast time goes and for whom it stands still, and nothing else: re-execution has its own.
PACE = frozenset(("rate", "hold", "lockstep_timeout"))


@dataclass
class NodeParameters:
    """Parameters of one node.

    Attributes
    ----------
    start
        Values by name.
    changes
        With publish times, ns.
    notes
        What the bag does not say for certain.
    """

    start: dict[str, Any]
    changes: list[tuple[int, Changed]]
    notes: list[str] = field(default_factory=list)


def node_parameters(recording: Recording, namespace: str, node: str, given: Mapping[str, Any]) -> NodeParameters:
    """Return the parameters of ``node``.

    Parameters
    ----------
    recording
        The bag.
    namespace
        Of the graph, with a slash at its end.
    node
        Name of the node.
    given
        Values by name that hold from the start to the end instead of the recorded ones.

    Raises
    ------
    ReexecutionError
        If the bag does not say with which parameters the node was started.
    """
    events = _events(recording, namespace + node)
    attached = recording.attachment(parameters_attachment(namespace + node))
    notes = []
    if attached is not None:
        start = _parameter_file(attached.data, node)
    else:
        start = _of_scenario(recording, namespace, node, events)
        notes.append(
            f"the bag has no parameters/{node}.yaml: started with those of its scenario, others as they are by default"
        )
    changes = []
    for time, event in events:
        # What was declared before they were asked for is known; later, one without a value was given one.
        later = event.new_parameters if attached is not None and time > attached.time else ()
        kept = [one for one in [*event.changed_parameters, *later] if one.name not in given and one.name not in PACE]
        if kept:
            changes.append((time, Changed(tuple(kept))))
    fitted = {name: _fit(value, start.get(name)) for name, value in given.items()}
    return NodeParameters({**start, **fitted}, changes, notes)


def _fit(value: Any, recorded: Any) -> Any:
    """Return a whole number as a real one where the recorded value is real."""
    if isinstance(recorded, float) and type(value) is int:
        return float(value)
    if isinstance(recorded, list) and isinstance(value, list) and any(isinstance(one, float) for one in recorded):
        return [float(one) if type(one) is int else one for one in value]
    return value


def _events(recording: Recording, full_name: str) -> list[tuple[int, ParameterEvent]]:
    topic = recording.topics.get(_EVENTS)
    found = []
    for message in topic.messages if topic is not None else ():
        event = deserialize_message(message.data, ParameterEvent)
        if event.node == full_name:
            found.append((message.published, event))
    return found


def _parameter_file(data: bytes, node: str) -> dict[str, Any]:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "parameters.yaml"
        path.write_bytes(data)
        return read_parameter_file(path).get(node, {})


def _of_scenario(
    recording: Recording, namespace: str, node: str, events: Sequence[tuple[int, ParameterEvent]]
) -> dict[str, Any]:
    """Return the start parameters of a bag from before they were recorded."""
    if recording.attachment(SCENARIO_ATTACHMENT) is None:
        raise ReexecutionError(
            f"{recording.path}: holds neither parameters/{node}.yaml nor a scenario: expected one of them, which says "
            f"with which parameters {node} was started"
        )
    from dp_tools.bag_reader import documents  # it loads much that is not needed otherwise

    attachments = {one.name: one.data for one in reversed(recording.attachments)}
    _, scenario = documents(attachments, "", recording.path)
    start: dict[str, Any] = dict(scenario.start_parameters.get(node, {})) if scenario is not None else {}
    lockstep = in_lockstep(recording, namespace)
    if node in RING_PACKAGES:
        start["synchronous"] = lockstep
    elif node == SIMULATOR_PACKAGE:
        start["lockstep"] = lockstep
    # What the recorder heard of the declaration is as the node took it.
    for _, event in events:
        for one in event.new_parameters:
            if (value := parameter_value_to_python(one.value)) is not None:
                start[one.name] = value
    return start


def in_lockstep(recording: Recording, namespace: str) -> bool:
    """Return whether the simulator waited for the ring: thruster_feedback comes after the command for its pose."""
    commands = recording.topics.get(f"{namespace}thruster_command")
    feedback = recording.topics.get(f"{namespace}thruster_feedback")
    if commands is None or feedback is None:
        return False
    asked = {stamp_of(message.data): message.published for message in commands.messages}
    pairs = [(asked.get(stamp_of(message.data)), message.published) for message in feedback.messages]
    return all(command < published for command, published in pairs if command is not None)
