"""Services that rclpy gives every node, made to answer whatever they are asked.

What a service's handler raises ends the executor, and with it the node: a request with a parameter of an unknown type,
or for a transition that does not exist, would do.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter

Handler = Callable[[Any, Any], Any]
_KINDS = frozenset(kind.value for kind in Parameter.Type)


def guard_services(node: Node) -> None:
    """Let the services that ``node`` has by now refuse what their handlers raise for."""
    for service in node.services:
        service.callback = _guarded(node, service.srv_name, service.srv_type, service.callback)


def _guarded(node: Node, name: str, kind: Any, handle: Handler) -> Handler:
    def answer(request: Any, response: Any) -> Any:
        refusal = _wrong_kinds(request) if kind in (SetParameters, SetParametersAtomically) else ""
        if not refusal:
            try:
                return handle(request, response)
            except Exception as error:
                refusal = f"{type(error).__name__}: {error}"
        node.get_logger().warning(f"refused: {name}: {refusal}", throttle_duration_sec=1.0)
        result = SetParametersResult(successful=False, reason=refusal)
        if kind is SetParameters:
            response.results = [result] * len(request.parameters)
        elif kind is SetParametersAtomically:
            response.result = result
        return response

    return answer


def _wrong_kinds(request: Any) -> str:
    """Return what is wrong with the types that the parameters of a request have; empty if nothing is."""
    for parameter in request.parameters:
        if parameter.value.type not in _KINDS:
            return (
                f"parameter {parameter.name}: expected a type from 0 to {max(_KINDS)} of rcl_interfaces/ParameterType, "
                f"found {parameter.value.type}"
            )
    return ""
