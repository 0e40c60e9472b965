"""Parameters of a run that was sailed without middleware, as the nodes of the graph would have had and told them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from dp_bringup.parameter_file import to_parameter_file
from dp_bringup.workspace import RING_PACKAGES
from dp_tools.node_settings import ALLOCATOR, SIMULATOR
from dp_tools.recorder.attachments import parameters_attachment
from dp_tools.scenario import Event, Scenario
from marine_model import Vessel
from marine_model.settings import Settings, parameters_of, with_parameters

PARAMETER_EVENT = "rcl_interfaces/msg/ParameterEvent"
PARAMETER_EVENTS = "parameter_events"
# What a loop in process is: lockstep, as fast as it can, from event to event.
_LIKE: dict[str, dict[str, Any]] = {
    SIMULATOR: {"lockstep": True, "rate": 0.0, "hold": True},
    ALLOCATOR: {"initial_azimuth": "vessel"},
}
# Number and field of a value in rcl_interfaces/msg/ParameterValue, by type: of one, and of a sequence.
_ONE = {bool: (1, "bool_value"), int: (2, "integer_value"), float: (3, "double_value"), str: (4, "string_value")}
_MANY = {
    bool: (6, "bool_array_value"),
    int: (7, "integer_array_value"),
    float: (8, "double_array_value"),
    str: (9, "string_array_value"),
}
_ARRAYS = {
    "byte_array_value": np.uint8,
    "bool_array_value": np.bool_,
    "integer_array_value": np.int64,
    "double_array_value": np.float64,
}


def parameter_attachments(vessel: Vessel, scenario: Scenario) -> dict[str, bytes]:
    """Return a ROS parameter file of every node by the name of its attachment: all parameters at start."""
    files = {}
    for node, settings in scenario.settings(vessel).items():
        values: dict[str, Any] = {"vessel": vessel.name, "autostart": True, **_LIKE.get(node, {})}
        if node in RING_PACKAGES:
            values["synchronous"] = True
        own = parameters_of(settings)
        # A parameter without a value is not in a parameter file.
        values |= {name: _plain(value) for name, value in own.items() if value is not None}
        files[parameters_attachment(node)] = to_parameter_file({node: values}).encode()
    return files


def parameter_changes(vessel: Vessel, scenario: Scenario) -> Iterator[tuple[Event, str, dict[str, Any]]]:
    """Yield event, node, and value by name of the parameters that the event changes, in order."""
    settings: dict[str, Settings] = scenario.settings(vessel)
    for event in scenario.events:
        for node, changes in event.parameters.items():
            settings[node] = with_parameters(settings[node], changes)
            values = parameters_of(settings[node])
            yield event, node, {name: values[name] for name in changes}


def parameter_event(types: Mapping[str, Any], stamp: int, node: str, values: Mapping[str, Any]) -> Any:
    """Return the message with which a node tells of a change; ``types`` are rosbags' message classes by name."""
    sec, nanosec = divmod(stamp, 1_000_000_000)
    changed = [types["rcl_interfaces/msg/Parameter"](name, _value(types, value)) for name, value in values.items()]
    return types[PARAMETER_EVENT](types["builtin_interfaces/msg/Time"](sec, nanosec), f"/{node}", [], changed, [])


def _value(types: Mapping[str, Any], value: Any) -> Any:
    kind, name = _form(value)
    fields: dict[str, Any] = {
        "type": kind,
        "bool_value": False,
        "integer_value": 0,
        "double_value": 0.0,
        "string_value": "",
        "string_array_value": [],
    }
    fields |= {name: np.zeros(0, dtype=form) for name, form in _ARRAYS.items()}
    if value is not None:
        fields[name] = np.array(value, dtype=_ARRAYS[name]) if name in _ARRAYS else _plain(value)
    return types["rcl_interfaces/msg/ParameterValue"](**fields)


def _form(value: Any) -> tuple[int, str]:
    """Return number and field of a value; a setting that is left unset has none."""
    if value is None:
        return 0, "bool_value"
    if isinstance(value, tuple):
        # An empty one has no type of its own; such parameters are numbers.
        return _MANY[type(value[0]) if value else float]
    return _ONE[type(value)]


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
