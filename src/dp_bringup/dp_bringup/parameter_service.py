"""Parameters of running nodes, through the standard ROS parameter services."""

from __future__ import annotations

import array
from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, ParameterType
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter, parameter_value_to_python

from dp_bringup.operator_node import NoAnswerError, Operator
from marine_model.errors import DpError

_SECONDS = 5.0
_HIDDEN = frozenset({"start_type_description_service"})


class ParameterRefusedError(DpError):
    """A node refused a change of parameters; the message carries the node's reason."""


class RemoteParameters:
    """Parameters of one node.

    Parameters
    ----------
    operator
        Node to call through.
    node_name
        Name of the node, relative to the operator's namespace.
    """

    def __init__(self, operator: Operator, node_name: str) -> None:
        self._operator = operator
        self.name = node_name
        make = operator.node.create_client
        self._list = make(ListParameters, f"{node_name}/list_parameters")
        self._get = make(GetParameters, f"{node_name}/get_parameters")
        self._describe = make(DescribeParameters, f"{node_name}/describe_parameters")
        self._set = make(SetParametersAtomically, f"{node_name}/set_parameters_atomically")

    def close(self) -> None:
        """Give the service clients back."""
        for client in (self._list, self._get, self._describe, self._set):
            self._operator.node.destroy_client(client)

    def _call(self, client: Any, request: Any) -> Any:
        try:
            return self._operator.call(client, request, _SECONDS, f"an answer of node {self.name}")
        except NoAnswerError as error:
            raise NoAnswerError(f"node {self.name}: {error}; is it running? (dp topics shows the graph)") from error

    def names(self) -> list[str]:
        """Return the names of all parameters, sorted."""
        found = self._call(self._list, ListParameters.Request()).result.names
        return sorted(set(found) - _HIDDEN)

    def describe(self, names: list[str]) -> dict[str, ParameterDescriptor]:
        """Return descriptors by name. Raises ParameterRefusedError for an unknown name."""
        unknown = sorted(set(names) - set(self.names()))
        if unknown:
            raise ParameterRefusedError(
                f"node {self.name}: no parameter {', '.join(unknown)}; known: {', '.join(self.names())}"
            )
        answer = self._call(self._describe, DescribeParameters.Request(names=names))
        return {descriptor.name: descriptor for descriptor in answer.descriptors}

    def get(self, names: list[str] | None = None) -> dict[str, Any]:
        """Return values by name (default: all). Raises ParameterRefusedError for an unknown name."""
        wanted = self.names() if names is None else names
        if names is not None:
            self.describe(names)
        answer = self._call(self._get, GetParameters.Request(names=wanted))
        return {
            name: _plain(parameter_value_to_python(value)) for name, value in zip(wanted, answer.values, strict=True)
        }

    def set(self, values: Mapping[str, Any]) -> None:
        """Set all ``values`` or none.

        A whole number is taken for a real one where the parameter is real; every other mismatch is the node's to
        refuse.

        Raises
        ------
        ParameterRefusedError
            With the node's reason; nothing was changed.
        """
        descriptors = self.describe(list(values))
        parameters = [
            Parameter(name, value=_fit(value, descriptors[name].type)).to_parameter_msg()
            for name, value in values.items()
        ]
        result = self._call(self._set, SetParametersAtomically.Request(parameters=parameters)).result
        if not result.successful:
            raise ParameterRefusedError(f"node {self.name}: {result.reason}")

    def set_changeable(self, values: Mapping[str, Any]) -> list[str]:
        """Set what can change while running; read-only ones must agree already. Return the names set."""
        descriptors = self.describe(list(values))
        fixed = {name for name, descriptor in descriptors.items() if descriptor.read_only}
        present = self.get(sorted(fixed)) if fixed else {}
        differing = [name for name in sorted(fixed) if present[name] != values[name]]
        if differing:
            raise ParameterRefusedError(
                f"node {self.name}: read-only while running: "
                + ", ".join(f"{name} is {present[name]!r}, not {values[name]!r}" for name in differing)
            )
        changing = {name: value for name, value in values.items() if name not in fixed}
        if changing:
            self.set(changing)
        return sorted(changing)


def _fit(value: Any, kind: int) -> Any:
    if kind == ParameterType.PARAMETER_DOUBLE and type(value) is int:
        return float(value)
    if kind == ParameterType.PARAMETER_DOUBLE_ARRAY and isinstance(value, list | tuple):
        return [float(item) if type(item) is int else item for item in value]
    return list(value) if isinstance(value, tuple) else value


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, array.array | tuple) else value
