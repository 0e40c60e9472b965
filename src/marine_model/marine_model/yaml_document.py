"""YAML documents with line numbers: read one, check it against a schema, and say where it fails."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from marine_model.errors import DocumentError

Model = TypeVar("Model", bound=BaseModel)
FieldPath = tuple[str | int, ...]


class _Loader(yaml.SafeLoader):
    """SafeLoader that reads 1e7 as a number, as YAML 1.2 does, and refuses repeated keys."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"field '{key}' appears twice", key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep=deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$|^[-+]?\.inf$|^\.nan$"),
    list("-+0123456789."),
)


@dataclass(frozen=True)
class YamlDocument:
    """Parsed content of one file, and the line of every field in it."""

    path: Path
    content: dict[str, Any]
    lines: dict[FieldPath, int]

    def line(self, field: FieldPath) -> int:
        """Return the line (from 1) of ``field``, or of the nearest parent that is written down."""
        while field and field not in self.lines:
            field = field[:-1]
        return self.lines.get(field, 1)

    def problem(self, field: FieldPath, message: str) -> str:
        """Return one line of an error text: file, line, field, message."""
        name = ".".join(str(part) for part in field) or "document"
        return f"{self.path}:{self.line(field)}: {name}: {message}"

    def validate(self, model: type[Model]) -> Model:
        """Return the content as ``model``.

        Raises
        ------
        DocumentError
            One line per problem, each with file, line and field.
        """
        return validate(self.content, model, self)


def validate(content: dict[str, Any], model: type[Model], document: YamlDocument) -> Model:
    """Return ``content`` as ``model``; problems are located in ``document``. Raises DocumentError."""
    try:
        return model.model_validate(content)
    except ValidationError as error:
        problems = []
        for item in error.errors():
            field = _field_path(item["loc"], content)
            message = item["msg"].removeprefix("Value error, ")
            if item["type"] not in ("missing", "value_error") and not isinstance(item.get("input"), dict | list):
                message += f", found {item['input']!r}"
            problems.append(document.problem(field, message))
        raise DocumentError("\n".join(problems)) from error


def _field_path(location: tuple[str | int, ...], content: Any) -> FieldPath:
    """Drop the tags that pydantic adds for unions: keep what leads through ``content``."""
    path: list[str | int] = []
    for i, part in enumerate(location):
        if isinstance(content, dict) and path and isinstance(path[-1], int):
            if content.get("type") == part:
                continue  # the tag of a union told apart by its field "type"
        if isinstance(content, dict) and part in content:
            content = content[part]
        elif isinstance(content, list) and isinstance(part, int) and part < len(content):
            content = content[part]
        elif i < len(location) - 1:
            continue
        path.append(part)
    return tuple(path)


def _lines(node: yaml.Node, field: FieldPath, found: dict[FieldPath, int]) -> None:
    found.setdefault(field, node.start_mark.line + 1)
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            found[(*field, key.value)] = key.start_mark.line + 1
            _lines(value, (*field, key.value), found)
    elif isinstance(node, yaml.SequenceNode):
        for i, value in enumerate(node.value):
            _lines(value, (*field, i), found)


def read_yaml(path: Path) -> YamlDocument:
    """Read a YAML file whose top level is a mapping.

    Raises
    ------
    DocumentError
        If the file is missing, unreadable, not YAML, has a field twice, or is not a mapping.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise DocumentError(f"{path}: cannot be read: {reason}") from error
    try:
        node = yaml.compose(text, Loader=_Loader)
        content = yaml.load(text, Loader=_Loader)  # noqa: S506 - a SafeLoader
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise DocumentError(f"{path}:{line}: document: not valid YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise DocumentError(f"{path}:1: document: not valid YAML: {error}") from error
    if not isinstance(content, dict) or node is None:
        raise DocumentError(f"{path}:1: document: expected a mapping, found {type(content).__name__}")
    lines: dict[FieldPath, int] = {}
    _lines(node, (), lines)
    return YamlDocument(path, content, lines)
