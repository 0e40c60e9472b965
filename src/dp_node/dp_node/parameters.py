"""A core's Settings as ROS parameters: declared once, validated whole, swapped in whole."""

from __future__ import annotations

import sys
import types
import typing
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

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
from marine_model.settings import Settings, parameters_of, with_parameters

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
        values: dict[str, Any] = {}
        for name, default in parameters_of(defaults).items():
            descriptor = describe(self._model, name)
            value = list(default) if isinstance(default, tuple) else default
            # One without a value has no type in ROS until it is set; the model judges it then.
            descriptor.dynamic_typing = value is None
            try:
                declared = node.declare_parameter(name, value, descriptor)
            except ParameterException as error:
                raise InputError(f"parameter {name}: {error}") from error
            values[name] = declared.value
        self._names = frozenset(values)
        self.current = self._validated(defaults, values)
        node.add_on_set_parameters_callback(self._judge)
        node.add_post_set_parameters_callback(self._swap)

    def _validated(self, base: S, changes: dict[str, Any]) -> S:
        settings = with_parameters(base, changes)
        self._check(settings)
        return settings

    def _own(self, parameters: Iterable[Parameter]) -> dict[str, Any]:
        """Return the values of those parameters that are settings; others are the node's own."""
        return {p.name: p.value for p in parameters if p.name in self._names}

    def _judge(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            self._validated(self.current, self._own(parameters))
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _swap(self, parameters: list[Parameter]) -> None:
        changes = self._own(parameters)
        if changes:
            self.current = self._validated(self.current, changes)
            self._apply(self.current)


def describe(model: type[Settings], name: str) -> ParameterDescriptor:
    """Return the descriptor of parameter ``name`` (dots for groups): type, text with unit, range."""
    field = parameter_field(model, name)
    extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    unit = str(extra.get("unit") or "")
    text = f"{field.description} [{unit}]" if unit not in ("", "1") else str(field.description)
    kind, choices = _type(field.annotation)
    if choices:
        text += f" (one of: {', '.join(choices)})"
    descriptor = ParameterDescriptor(name=name, type=kind, description=text, read_only=bool(extra.get("read_only")))
    low, high = limits(field)
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
    elif kind in (ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_DOUBLE_ARRAY):
        # Of an array, ROS only shows the range, of every element; the settings judge by it.
        largest = sys.float_info.max
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-largest if low is None else float(low),
                to_value=largest if high is None else float(high),
                step=0.0,
            )
        ]
    return descriptor


def limits(field: FieldInfo) -> tuple[float | None, float | None]:
    """Return the range of a setting, or of every element of one that is an array; None where it has no end."""
    metadata = [*field.metadata, *_element_metadata(field.annotation)]
    low = next((m.ge if hasattr(m, "ge") else m.gt for m in metadata if hasattr(m, "ge") or hasattr(m, "gt")), None)
    high = next((m.le for m in metadata if hasattr(m, "le")), None)
    return low, high


def _element_metadata(annotation: Any) -> list[Any]:
    origin = typing.get_origin(annotation)
    if origin is typing.Annotated:
        inner, *extra = typing.get_args(annotation)
        return [m for item in extra for m in getattr(item, "metadata", [item])] + _element_metadata(inner)
    return _element_metadata(typing.get_args(annotation)[0]) if origin is tuple else []


def parameter_field(model: type[Settings], name: str) -> FieldInfo:
    """Return the field that declares parameter ``name`` (dots for groups)."""
    head, _, rest = name.partition(".")
    field = model.model_fields[head]
    if not rest:
        return field
    group = field.annotation
    if not (isinstance(group, type) and issubclass(group, Settings)):
        raise TypeError(f"{model.__name__}.{head}: expected a group of settings, found {group}")
    return parameter_field(group, rest)


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
        # A setting may be left unset; apart from that a parameter has one type.
        kinds = [kind for kind in typing.get_args(annotation) if kind is not type(None)]
        if len(kinds) != 1:
            raise TypeError(f"a parameter has one type, found {annotation}")
        return _type(kinds[0])
    return _SCALARS[annotation], ()
