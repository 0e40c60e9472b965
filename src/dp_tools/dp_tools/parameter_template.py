"""Parameter files written from the declarations: every parameter that can change, with default, unit and meaning."""

from __future__ import annotations

import typing
from collections.abc import Iterator

from dp_bringup.parameter_file import yaml_value
from dp_node.parameters import limits, parameter_field
from dp_tools.node_settings import declared_settings
from marine_model import Vessel
from marine_model.errors import UnknownNameError
from marine_model.settings import Settings, parameters_of, read_only_parameters


def parameter_template(node: str, vessel_name: str, vessel: Vessel) -> str:
    """Return a ROS parameter file for ``node``: the defaults for ``vessel``, what each means above it.

    What cannot change while the node runs is not in it, and what has no value by default stands there as a comment.

    Raises
    ------
    UnknownNameError
        If there is no such node.
    """
    settings = declared_settings(vessel)
    if node not in settings:
        raise UnknownNameError(f"node: expected one of {', '.join(settings)}, found '{node}'")
    return "\n".join(_lines(node, vessel_name, settings[node])) + "\n"


def _lines(node: str, vessel_name: str, settings: Settings) -> Iterator[str]:
    yield f"# Parameters of {node} with their defaults for the vessel {vessel_name}; written by"
    yield f"#     dp param template {node} --vessel {vessel_name}"
    yield f"/**/{node}:"
    yield "  ros__parameters:"
    model = type(settings)
    fixed = read_only_parameters(model)
    for name, value in parameters_of(settings).items():
        if name in fixed:
            continue
        field = parameter_field(model, name)
        yield f"    # {field.description}{_remark(model, name)}"
        # ROS cannot read a list without elements.
        hidden = "# " if value is None or value == () else ""
        plain = list(value) if isinstance(value, tuple) else value
        yield f"    {hidden}{name}: {yaml_value(plain)}"


def _remark(model: type[Settings], name: str) -> str:
    """Return unit, range and choices of a parameter."""
    field = parameter_field(model, name)
    extra = field.json_schema_extra
    unit = extra.get("unit") if isinstance(extra, dict) else ""
    parts = [f"[{unit}]"] if unit not in ("", "1", None) else []
    low, high = limits(field)
    if low is not None and high is not None:
        parts.append(f"{low:g} to {high:g}")
    elif low is not None:
        parts.append(f"{low:g} or more")
    if typing.get_origin(field.annotation) is typing.Literal:
        parts.append(f"one of {', '.join(map(str, typing.get_args(field.annotation)))}")
    return f"; {', '.join(parts)}" if parts else ""
