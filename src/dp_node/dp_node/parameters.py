"""A core's Settings as ROS parameters: declared once, validated whole, swapped in whole."""

from __future__ import annotations

import sys
import types
import typing
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from marine_model.errors import InputError
from marine_model.settings import Settings

S = TypeVar("S", bound=Settings)

_SCALARS = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
}
_ARRAYS = {
    bool: ParameterType.PARAMETER_BOOL_ARRAY,
    int: ParameterType.PARAMETER_INTEGER_ARRAY,
    float: ParameterType.PARAMETER_DOUBLE_ARRAY,
    str: ParameterType.PARAMETER_STRING_ARRAY,
}


class SettingsParameters(Generic[S]):
    """Keeps one ``Settings`` object and a node's parameters the same.

    Parameters
    ----------
    node
        Declares the parameters here.
    defaults
        Values where nothing overrides them; its class gives names, types, ranges and descriptions.
    check
        Refuses settings that do not fit the vessel, by raising InputError.
    apply
        Called with the new settings after a change was accepted.

    Raises
    ------
    InputError
        If the values given at start-up (command line, parameter file) are refused; the message says which and why.
    """

    def __init__(self, node: Node, defaults: S, check: Callable[[S], None], apply: Callable[[S], None]) -> None:
        self._model = type(defaults)
        self._check = check
        self._apply = apply
        self._candidate: S | None = None
        self._names = dict(_flatten(defaults.model_dump()))
        values: dict[str, Any] = {}
        for name, default in self._names.items():
            descriptor = describe(self._model, name)
            value = list(default) if isinstance(default, tuple) else default
            try:
                declared = node.declare_parameter(name, value, descriptor)
            except ParameterException as error:
                raise InputError(f"parameter {name}: {error}") from error
            values[name] = declared.value
        self.current = self._validated(values)
        node.add_on_set_parameters_callback(self._judge)
        node.add_post_set_parameters_callback(self._swap)

    def _validated(self, values: dict[str, Any]) -> S:
        try:
            settings = self._model.model_validate(_nest(values))
        except ValidationError as error:
            raise InputError(explain(error)) from error
        self._check(settings)
        return settings

    def _merged(self, parameters: Iterable[Parameter]) -> dict[str, Any] | None:
        changed = {p.name: p.value for p in parameters if p.name in self._names}
        if not changed:
            return None
        return dict(_flatten(self.current.model_dump())) | changed

    def _judge(self, parameters: list[Parameter]) -> SetParametersResult:
        values = self._merged(parameters)
        if values is None:
            return SetParametersResult(successful=True)
        try:
            self._validated(values)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _swap(self, parameters: list[Parameter]) -> None:
        values = self._merged(parameters)
        if values is not None:
            self.current = self._validated(values)
            self._apply(self.current)


def explain(error: ValidationError) -> str:
    """Return a pydantic error as one line: every field with what is wrong and what was found."""
    parts = []
    for item in error.errors():
        field = ".".join(str(part) for part in item["loc"])
        text = item["msg"].removeprefix("Value error, ")
        found = "" if item["type"] == "value_error" else f", found {item['input']!r}"
        parts.append(f"{field}: {text}{found}" if field else f"{text}{found}")
    return "; ".join(parts)


def describe(model: type[Settings], name: str) -> ParameterDescriptor:
    """Return the descriptor of parameter ``name`` (dots for groups): type, text with unit, range."""
    field = _field(model, name)
    extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    unit = str(extra.get("unit") or "")
    text = f"{field.description} [{unit}]" if unit else str(field.description)
    kind, choices = _type(field.annotation)
    if choices:
        text += f" (one of: {', '.join(choices)})"
    descriptor = ParameterDescriptor(name=name, type=kind, description=text, read_only=bool(extra.get("read_only")))
    low = next((m.ge for m in field.metadata if hasattr(m, "ge")), None)
    high = next((m.le for m in field.metadata if hasattr(m, "le")), None)
    if low is None and high is None:
        return descriptor
    if kind == ParameterType.PARAMETER_INTEGER:
        descriptor.integer_range = [
            IntegerRange(
                from_value=-(2**63) if low is None else int(low),
                to_value=2**63 - 1 if high is None else int(high),
                step=0,
            )
        ]
    elif kind == ParameterType.PARAMETER_DOUBLE:
        largest = sys.float_info.max
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-largest if low is None else float(low),
                to_value=largest if high is None else float(high),
                step=0.0,
            )
        ]
    return descriptor


def _field(model: type[Settings], name: str) -> FieldInfo:
    head, _, rest = name.partition(".")
    field = model.model_fields[head]
    if not rest:
        return field
    group = field.annotation
    if not (isinstance(group, type) and issubclass(group, Settings)):
        raise TypeError(f"{model.__name__}.{head}: expected a group of settings, found {group}")
    return _field(group, rest)


def _type(annotation: Any) -> tuple[int, tuple[str, ...]]:
    """Return the ROS type of a field and, for a choice of strings, its choices."""
    origin = typing.get_origin(annotation)
    if origin is typing.Annotated:
        return _type(typing.get_args(annotation)[0])
    if origin is typing.Literal:
        choices = tuple(str(choice) for choice in typing.get_args(annotation))
        return ParameterType.PARAMETER_STRING, choices
    if origin is tuple:
        element, choices = typing.get_args(annotation)[0], ()
        if typing.get_origin(element) is typing.Annotated:
            element = typing.get_args(element)[0]
        return _ARRAYS[element], choices
    if isinstance(annotation, types.UnionType):
        raise TypeError(f"a parameter has one type, found {annotation}")
    return _SCALARS[annotation], ()


def _flatten(tree: dict[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _nest(flat: dict[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for name, value in flat.items():
        *groups, leaf = name.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        # rclpy hands arrays over as array.array or list; the models keep tuples.
        branch[leaf] = tuple(value) if not isinstance(value, str | bytes | bool | int | float) else value
    return tree
