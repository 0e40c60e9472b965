"""YAML documents with line numbers: read one, check it against a schema, and say where it fails."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from marine_model.errors import DocumentError
from marine_model.schema import FieldError

Model = TypeVar("Model", bound=BaseModel)
FieldPath = tuple[str | int, ...]


class _Loader(yaml.SafeLoader):
    """YAML 1.2 (core schema) for PyYAML, which is at 1.1, with field names that are words and appear once.

    In 1.1 ``1:30`` is ninety, ``010`` is eight, ``no`` is false, ``2020-01-01`` is a date and 1e7 is a string.
    """

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode) or key_node.tag != "tag:yaml.org,2002:str":
                raise yaml.constructor.ConstructorError(
                    None, None, "expected a word for a field name", key_node.start_mark
                )
            key = key_node.value
            if key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"field '{key}' appears twice", key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep=deep)

    def construct_whole_number(self, node: yaml.ScalarNode) -> int:
        """Read 0x1f and 0o17 by their base, everything else as decimal."""
        digits = node.value.lower()
        return int(digits, 0) if digits.startswith(("0x", "0o")) else int(digits, 10)


_Loader.yaml_implicit_resolvers = {}
for _kind, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", list("-+0123456789")),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        list("-+0123456789."),
    ),
):
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_kind}", re.compile(rf"(?:{_pattern})$"), _first)
_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_whole_number)


def parse_value(text: str) -> Any:
    """Return what ``text`` means as a value in a document: true, 3, 1e-7, [1.0, 2.0]; else the text itself."""
    try:
        return yaml.load(text, _Loader)  # noqa: S506 - a safe loader
    except yaml.YAMLError:
        return text


# Aliases may repeat parts of a file; far beyond any real vessel or scenario they are an attack or an accident.
_LARGEST_DOCUMENT = 100_000  # values
_LONGEST_VALUE = 60  # characters of a wrong value that an error text repeats


@dataclass(frozen=True)
class YamlDocument:
    """Parsed content of one file, and the line of every field in it.

    ``files`` names, for fields that come from a file which this one extends, that file.
    """

    path: Path
    content: dict[str, Any]
    lines: dict[FieldPath, int]
    files: dict[FieldPath, Path] = field(default_factory=dict)

    def problem(self, field: FieldPath, message: str) -> str:
        """Return one line of an error text: file, line, field, message.

        The line (from 1) is that of ``field``, or of its nearest parent that is written down.
        """
        name = ".".join(str(part) for part in field) or "document"
        while field and field not in self.lines:
            field = field[:-1]
        return f"{self.files.get(field, self.path)}:{self.lines.get(field, 1)}: {name}: {message}"

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
        items = error.errors()
        for item in items:
            if item["type"] == "too_short" and any(_below(other["loc"], item["loc"]) for other in items):
                continue  # pydantic counts the entries that it took, not those that are there
            field = _field_path(item["loc"], content, item["type"] == "missing")
            message = item["msg"].removeprefix("Value error, ")
            if item["type"] == "value_error" and isinstance(item["ctx"]["error"], FieldError):
                field += item["ctx"]["error"].field
            if item["type"] == "union_tag_not_found":
                message = f"expected a field {item['ctx']['discriminator']}"
            if item["type"] not in ("missing", "value_error", "union_tag_not_found") and not isinstance(
                item.get("input"), dict | list
            ):
                message += f", found {_short(item['input'])}"
            problems.append(document.problem(field, message))
        raise DocumentError("\n".join(problems)) from error


def _below(location: tuple[str | int, ...], parent: tuple[str | int, ...]) -> bool:
    return len(location) > len(parent) and location[: len(parent)] == parent


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST_VALUE else text[:_LONGEST_VALUE] + "..."


def _field_path(location: tuple[str | int, ...], content: Any, missing: bool) -> FieldPath:
    """Drop the tags that pydantic adds for unions: keep what leads through ``content``.

    The last part is no tag where the field it names is ``missing``.
    """
    path: list[str | int] = []
    tag_comes = False  # an entry of a list, and nothing in it yet
    for i, part in enumerate(location):
        if tag_comes and isinstance(content, dict) and content.get("type") == part:
            tag_comes = False
            continue  # the tag of a union told apart by its field "type"
        tag_comes = isinstance(part, int)
        if isinstance(content, dict) and part in content:
            content = content[part]
        elif isinstance(content, list) and isinstance(part, int) and part < len(content):
            content = content[part]
        elif i < len(location) - 1 or (isinstance(content, dict) and not missing):
            continue
        path.append(part)
    return tuple(path)


def _lines(node: yaml.Node) -> dict[FieldPath, int]:
    """Return the line of every field. Raises YAMLError for a document that contains itself or is too large."""
    found: dict[FieldPath, int] = {}
    enclosing: set[int] = set()

    def visit(node: yaml.Node, place: FieldPath) -> None:
        if id(node) in enclosing or len(found) > _LARGEST_DOCUMENT:
            reason = "a part contains itself" if id(node) in enclosing else f"more than {_LARGEST_DOCUMENT} values"
            raise yaml.constructor.ConstructorError(None, None, reason, node.start_mark)
        enclosing.add(id(node))
        found.setdefault(place, node.start_mark.line + 1)
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                if isinstance(key, yaml.ScalarNode):
                    found[(*place, key.value)] = key.start_mark.line + 1
                    visit(value, (*place, key.value))
        elif isinstance(node, yaml.SequenceNode):
            for i, value in enumerate(node.value):
                visit(value, (*place, i))
        enclosing.discard(id(node))

    visit(node, ())
    return found


def _parse(text: str) -> tuple[Any, dict[FieldPath, int]]:
    loader = _Loader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None, {}
        lines = _lines(node)
        return loader.construct_document(node), lines
    finally:
        loader.dispose()


def read_yaml(path: Path) -> YamlDocument:
    """Read a YAML 1.2 file whose top level is a mapping.

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
        content, lines = _parse(text)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise DocumentError(f"{path}:{line}: document: not valid YAML: {error.problem}") from error
    except RecursionError as error:
        raise DocumentError(f"{path}:1: document: not valid YAML: nested too deeply") from error
    except (yaml.YAMLError, ValueError) as error:
        # Some of PyYAML's own errors, and what Python's number and date types say to nonsense.
        raise DocumentError(f"{path}:1: document: not valid YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise DocumentError(f"{path}:1: document: expected a mapping, found {type(content).__name__}")
    return YamlDocument(path, content, lines)
