"""One real node on a bench: driven and heard over real DDS, in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rcl_interfaces.srv import DescribeParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from dp_node import RING, RING_PUBLISHER, DpNode, RingExecutor
from support.waiting import wait_until


class NodeBench:
    """A node under test and a probe node beside it, on one executor."""

    def __init__(self, node: DpNode[Any]) -> None:
        self.node = node
        self.probe = rclpy.create_node("probe")
        self.executor = RingExecutor()
        self.executor.add_node(node)
        self.executor.add_node(self.probe)
        self.heard: dict[str, list[Any]] = {}

    def spin(self, seconds: float) -> None:
        self.executor.spin_once(timeout_sec=seconds)

    def wait_until(self, condition: Callable[[], object], message: str | Callable[[], str] = "") -> None:
        wait_until(condition, message=message, spin=self.spin)

    def publisher(self, kind: Any, topic: str) -> Any:
        """A publisher that the node already listens to."""
        made = self.probe.create_publisher(kind, topic, RING_PUBLISHER)
        self.wait_until(lambda: made.get_subscription_count() > 0, f"a subscriber of {topic}")
        return made

    def hear(self, kind: Any, topic: str) -> list[Any]:
        """The list into which messages of ``topic`` come; the publisher is already matched."""
        messages = self.heard.setdefault(topic, [])
        subscription = self.probe.create_subscription(kind, topic, messages.append, RING)
        self.wait_until(lambda: subscription.get_publisher_count() > 0, f"a publisher of {topic}")
        return messages

    def wait_for(self, topic: str, count: int = 1) -> list[Any]:
        """Wait until ``count`` messages in all have come on a topic that is heard."""
        messages = self.heard[topic]
        self.wait_until(lambda: len(messages) >= count, lambda: f"{count} messages on {topic}, have {len(messages)}")
        return messages

    def set_parameters(self, **values: Any) -> SetParametersResult:
        """Set parameters together through the node's service; two underscores stand for the dot of a group."""
        request = SetParametersAtomically.Request(parameters=_messages(values))
        return self.call(SetParametersAtomically, "set_parameters_atomically", request).result

    def set_one_by_one(self, **values: Any) -> list[SetParametersResult]:
        """Set parameters through the service that judges each for itself."""
        request = SetParameters.Request(parameters=_messages(values))
        return list(self.call(SetParameters, "set_parameters", request).results)

    def describe_parameters(self, names: list[str]) -> list[ParameterDescriptor]:
        """Return what the node says of its parameters."""
        request = DescribeParameters.Request(names=names)
        return list(self.call(DescribeParameters, "describe_parameters", request).descriptors)

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service of the node and return its answer."""
        client = self.probe.create_client(kind, f"{self.node.get_name()}/{service}")
        self.wait_until(client.service_is_ready, f"the service {service}")
        future = client.call_async(request)
        self.wait_until(future.done, f"an answer of {service}")
        self.probe.destroy_client(client)
        return future.result()

    def diagnostics(self) -> dict[str, Any]:
        """Publish and return what the node says of itself: level, message and values."""
        messages = self.heard.get("/diagnostics") or self.hear(DiagnosticArray, "/diagnostics")
        count = len(messages)
        self.node.publish_diagnostics()
        self.wait_until(lambda: len(messages) > count, "diagnostics")
        (status,) = messages[-1].status
        return {
            "level": status.level[0],
            "message": status.message,
            **{value.key: value.value for value in status.values},
        }


def _messages(values: dict[str, Any]) -> list[Any]:
    return [Parameter(name.replace("__", "."), value=value).to_parameter_msg() for name, value in values.items()]


@contextmanager
def node_bench(make: Callable[..., DpNode[Any]], **parameters: Any) -> Iterator[NodeBench]:
    """Start a node with start-up ``parameters``, active unless ``autostart`` is false; needs fixture ros_domain_id."""
    rclpy.init()
    bench: NodeBench | None = None
    try:
        overrides = [Parameter(name.replace("__", "."), value=value) for name, value in parameters.items()]
        bench = NodeBench(make(parameter_overrides=overrides))
        bench.node.start()
        yield bench
    finally:
        if bench is not None:
            bench.executor.shutdown()
            bench.probe.destroy_node()
            bench.node.destroy_node()
        rclpy.try_shutdown()
