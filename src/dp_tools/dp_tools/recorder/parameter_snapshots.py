"""Parameters of a node as a file, and what has become of them since."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.parameter import parameter_value_to_python
from rclpy.serialization import deserialize_message

from dp_bringup.parameter_file import to_parameter_file
from dp_tools.recorder.attachments import parameters_attachment

_HIDDEN = frozenset({"start_type_description_service"})


@dataclass
class Snapshot:
    """All parameters of one node.

    Attributes
    ----------
    node
        Full name.
    time
        When they were asked for, ns of wall-clock time. A change published later may not be in them.
    values
        By name.
    """

    node: str
    time: int
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the attachment."""
        return parameters_attachment(self.node)

    def document(self) -> bytes:
        """Return them as a ROS parameter file."""
        return to_parameter_file({self.node.rpartition("/")[2]: dict(sorted(self.values.items()))}).encode()


def values_of(names: Sequence[str], values: Sequence[Any]) -> dict[str, Any]:
    """Return what an answer of GetParameters tells, by name."""
    found: dict[str, Any] = {}
    for name, value in zip(names, values, strict=True):
        _put(found, name, value)
    return found


def _put(values: dict[str, Any], name: str, value: Any) -> None:
    # A parameter without a value has no place in a parameter file.
    if name in _HIDDEN or value.type == ParameterType.PARAMETER_NOT_SET:
        values.pop(name, None)
        return
    plain = parameter_value_to_python(value)
    if value.type == ParameterType.PARAMETER_BYTE_ARRAY:
        plain = [byte[0] for byte in plain]
    # Arrays of numbers come as array.array.
    values[name] = plain if isinstance(plain, bool | int | float | str) else list(plain)


class Snapshots:
    """The last snapshot of every node, brought up to date by parameter events when asked for."""

    def __init__(self) -> None:
        self._snapshots: dict[str, Snapshot] = {}
        self._events: list[tuple[int, bytes]] = []

    def add(self, snapshot: Snapshot) -> None:
        """Take a snapshot; it replaces the node's last."""
        self._snapshots[snapshot.node] = snapshot

    def note(self, publish_time: int, event: bytes) -> None:
        """Take a serialized ParameterEvent with its publish time, ns."""
        self._events.append((publish_time, event))

    def at_present(self) -> dict[str, bytes]:
        """Return the parameter files of all nodes with all changes so far, by name of their attachments."""
        events, self._events = self._events, []
        for publish_time, data in events:
            event = deserialize_message(data, ParameterEvent)
            snapshot = self._snapshots.get(event.node)
            if snapshot is None or publish_time < snapshot.time:
                continue
            for parameter in (*event.new_parameters, *event.changed_parameters):
                _put(snapshot.values, parameter.name, parameter.value)
            for parameter in event.deleted_parameters:
                snapshot.values.pop(parameter.name, None)
        return {snapshot.name: snapshot.document() for snapshot in self._snapshots.values()}
