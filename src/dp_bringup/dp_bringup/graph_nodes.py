"""Which nodes of the graph are there, and which are active."""

from __future__ import annotations

from typing import Any

from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState

from dp_bringup.operator_node import Operator
from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE

# Every node has the name of its package.
NODES = (*RING_PACKAGES, SIMULATOR_PACKAGE)
# Far above what a start takes; on a machine with much else to do, seven interpreters need their time.
START_SECONDS = 60.0
# DDS participants announce themselves every 3 s, and the answer to a newcomer's own announcement may be lost.
ANNOUNCEMENT_SECONDS = 3.2


def present(operator: Operator) -> list[str]:
    """Return the nodes of the graph known in the operator's namespace by now; a name as often as it is there."""
    here = operator.node.get_namespace()
    return sorted(
        name for name, namespace in operator.node.get_node_names_and_namespaces() if namespace == here and name in NODES
    )


def is_there(operator: Operator, name: str) -> bool:
    """Return whether node ``name`` is known in the operator's namespace by now."""
    return (name, operator.node.get_namespace()) in operator.node.get_node_names_and_namespaces()


def unheard(operator: Operator, listener: str) -> list[str]:
    """Return the topics of the graph's nodes and of the operator to which node ``listener`` does not listen.

    Hidden ones do not count.
    """
    node, namespace = operator.node, operator.node.get_namespace()
    topics = {
        topic
        for name in {*present(operator), node.get_name()}
        for topic, _ in node.get_publisher_names_and_types_by_node(name, namespace)
    }
    return sorted(
        topic
        for topic in topics
        if not any(part.startswith("_") for part in topic.split("/"))
        and not any(info.node_name == listener for info in node.get_subscriptions_info_by_topic(topic))
    )


def wait_until_active(operator: Operator) -> None:
    """Wait until every node of the graph is active. Raises NoAnswerError, naming the one that is not."""
    for name in NODES:
        client = operator.node.create_client(GetState, f"{name}/get_state")

        def active(client: Any = client, name: str = name) -> bool:
            answer = operator.call(client, GetState.Request(), START_SECONDS, f"the state of {name}")
            return bool(answer.current_state.id == State.PRIMARY_STATE_ACTIVE)

        operator.wait_until(client.service_is_ready, START_SECONDS, f"node {name}")
        operator.wait_until(active, START_SECONDS, f"node {name} to become active")
        operator.node.destroy_client(client)
