"""ROS parameter files, written and read without ROS."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from marine_model.errors import DocumentError
from marine_model.yaml_document import parse_value, read_yaml


class _Dumper(yaml.SafeDumper):
    """Puts a text into quotes wherever YAML 1.2 or 1.1 would take it for something else."""

    def represent_text(self, data: str) -> yaml.ScalarNode:
        return self.represent_scalar("tag:yaml.org,2002:str", data, style=None if parse_value(data) == data else '"')


_Dumper.add_representer(str, _Dumper.represent_text)


def yaml_value(value: Any) -> str:
    """Return a value of a parameter as it stands in a parameter file, on one line."""
    text: str = yaml.dump(value, Dumper=_Dumper, default_flow_style=True, width=sys.maxsize)
    return text.removesuffix("\n").removesuffix("...").strip()


def to_parameter_file(values: Mapping[str, Mapping[str, Any]]) -> str:
    """Return a ROS parameter file: values by node and name, for nodes in any namespace."""
    tree = {f"/**/{node}": {"ros__parameters": dict(own)} for node, own in values.items()}
    text: str = yaml.dump(tree, Dumper=_Dumper, sort_keys=False, default_flow_style=None)
    return text


def read_parameter_file(path: Path) -> dict[str, dict[str, Any]]:
    """Return values by node and name out of a ROS parameter file.

    Raises
    ------
    DocumentError
        If it cannot be read or has another structure.
    """
    document = read_yaml(path)
    values: dict[str, dict[str, Any]] = {}
    for node, section in document.content.items():
        own = section.get("ros__parameters") if isinstance(section, dict) and len(section) == 1 else None
        if not isinstance(own, dict):
            raise DocumentError(document.problem((node,), "expected one mapping ros__parameters"))
        values[str(node).rsplit("/", 1)[-1]] = dict(_flatten(own))
    return values


def _flatten(tree: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for key, value in tree.items():
        if isinstance(value, Mapping):
            found += _flatten(value, f"{prefix}{key}.")
        else:
            found.append((f"{prefix}{key}", value))
    return found
