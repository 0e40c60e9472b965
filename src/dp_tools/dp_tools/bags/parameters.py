"""Parameters of nodes in a bag: what they were when it began, and what became of them."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dp_bringup.parameter_file import read_parameter_file
from dp_tools.bags.bag import Bag
from dp_tools.bags.decode import TopicDecoder

FOLDER = "parameters/"
EVENTS = "/parameter_events"
# Field of rcl_interfaces/msg/ParameterValue by its type number.
_VALUES = {
    1: "bool_value",
    2: "integer_value",
    3: "double_value",
    4: "string_value",
    5: "byte_array_value",
    6: "bool_array_value",
    7: "integer_array_value",
    8: "double_array_value",
    9: "string_array_value",
}


@dataclass(frozen=True)
class Snapshot:
    """All parameters of a node at one time.

    Attributes
    ----------
    node
        Full name, ``/ship/thrust_allocator``.
    time
        When they were taken, ns since 1970.
    values
        By name.
    repeated
        Whether a further file of a split bag only repeats what had been taken before.
    """

    node: str
    time: int
    values: Mapping[str, Any]
    repeated: bool = False


@dataclass(frozen=True)
class Change:
    """A parameter event: ``values`` by name, None for one that is gone; ``time`` is that of publishing, ns."""

    node: str
    time: int
    values: Mapping[str, Any]


def snapshots(bag: Bag) -> list[Snapshot]:
    """Return the parameters attached to a bag, in the order of the files. Raises DpError if they cannot be read."""
    found = []
    for attachment in bag.attachments:
        if attachment.name.startswith(FOLDER):
            name = attachment.name.removeprefix(FOLDER).removesuffix(".yaml")
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / f"{name.replace('/', '.')}.yaml"
                path.write_bytes(attachment.data)
                by_node = read_parameter_file(path)
            values = by_node.get(name.rpartition("/")[2], {})
            repeated = attachment.log_time > attachment.create_time
            found.append(Snapshot(f"/{name}", attachment.log_time, values, repeated))
    return found


def changes(bag: Bag) -> Iterator[Change]:
    """Yield the parameter events of a bag in the order of the files. Raises BagError if they cannot be read."""
    for number, topic in enumerate(bag.topics):
        if topic.name != EVENTS:
            continue
        decoder = TopicDecoder(topic)
        for row in np.flatnonzero(bag.messages.topic == number).tolist():
            event = decoder.message(bag.data(row))
            values: dict[str, Any] = {one.name: None for one in event.deleted_parameters}
            values |= {one.name: _value(one.value) for one in (*event.new_parameters, *event.changed_parameters)}
            yield Change(event.node, int(bag.messages.publish_time[row]), values)


def parameters_at(bag: Bag, time: int) -> list[Snapshot]:
    """Return the parameters of every node that was there at ``time``, ns since 1970, as they were then."""
    state: dict[str, Snapshot] = {}
    for snapshot in snapshots(bag):
        before = state.get(snapshot.node)
        if snapshot.time <= time and (before is None or before.time <= snapshot.time):
            state[snapshot.node] = snapshot
    values = {node: dict(snapshot.values) for node, snapshot in state.items()}
    for change in sorted(changes(bag), key=lambda one: one.time):
        own = values.get(change.node)
        if own is not None and state[change.node].time <= change.time < time:
            own.update(change.values)
    return [
        Snapshot(node, time, {name: value for name, value in own.items() if value is not None})
        for node, own in values.items()
    ]


def _value(value: Any) -> Any:
    found = getattr(value, _VALUES[value.type]) if value.type in _VALUES else None
    return found.tolist() if isinstance(found, np.ndarray) else found
