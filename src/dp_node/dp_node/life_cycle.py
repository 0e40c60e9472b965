"""What rclpy's life cycle leaves to be desired."""

from __future__ import annotations

from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.lifecycle import LifecycleNode


def refuse_impossible_transitions(node: LifecycleNode) -> None:
    """Let ``node`` answer a transition that its state does not have with ``success`` false.

    rclpy raises it in the callback of the service, which ends the process of whoever is asked to configure twice.
    """
    service = node._service_change_state
    change = service.callback

    def answer(request: Any, response: Any) -> Any:
        try:
            return change(request, response)
        except _rclpy.RCLError as error:
            node.get_logger().warning(
                f"refused: transition {request.transition.label or request.transition.id}: {error}"
            )
            response.success = False
            return response

    service.callback = answer
