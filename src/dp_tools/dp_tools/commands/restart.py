"""`dp restart`: let the supervisor of a graph start a node anew."""

from __future__ import annotations

import time
from typing import Annotated, Any

import typer
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.task import Future
from std_srvs.srv import Trigger

from dp_bringup.graph_nodes import NODES, START_SECONDS, present
from dp_bringup.operator_node import NoAnswerError, operator
from dp_bringup.supervisor import SUPERVISOR
from dp_node import RING
from dp_tools.commands.root import Namespace, console
from marine_model.errors import DpError

_DISCOVERY_SECONDS = 10.0
# The supervisor tells its state once a second: after so long it would have told of a restart that has begun.
_CALL_AGAIN_SECONDS = 4.0


class RestartError(DpError):
    """A restart cannot be had, or did not succeed; the message says why."""


def restart(
    node: Annotated[str, typer.Argument(metavar="NODE", help=f"One of {', '.join(NODES)}.", show_default=False)],
    namespace: Namespace = "",
) -> None:
    """Restart a node with its last parameters, or one that was given up; in a composed graph, all of them."""
    if node not in NODES:
        raise RestartError(f"node: expected one of {', '.join(NODES)}, found {node}")
    with operator(namespace) as one:
        phases: dict[str, str] = {}

        def note(message: Any) -> None:
            own = f"{one.node.get_namespace()}/{SUPERVISOR}".strip("/")
            for status in message.status:
                if status.name == own:
                    phases.update((item.key, item.value) for item in status.values)

        one.node.create_subscription(DiagnosticArray, "/diagnostics", note, RING)
        client = one.node.create_client(Trigger, f"{SUPERVISOR}/restart_{node}")
        try:
            one.wait_until(client.service_is_ready, _DISCOVERY_SECONDS, f"service {client.srv_name}")
        except NoAnswerError as error:
            there = ", ".join(sorted(set(present(one)))) or "no node of the graph"
            raise RestartError(
                f"namespace {one.node.get_namespace()}: expected a supervisor (dp up in real time), found {there}"
            ) from error
        one.wait_until(lambda: bool(phases), _DISCOVERY_SECONDS, "the diagnostics of the supervisor")
        unit = node if f"{node}.restarts" in phases else "composed"
        before = int(phases[f"{unit}.restarts"])
        phase = phases[f"{unit}.phase"]
        futures: list[Future] = []
        next_call = 0.0

        def restarted() -> bool:
            nonlocal next_call
            now = time.monotonic()
            untouched = int(phases[f"{unit}.restarts"]) == before and phases[f"{unit}.phase"] == phase
            # Only while nothing has come of the last one: another call would be another restart.
            if untouched and now >= next_call and not any(future.done() for future in futures):
                futures.append(client.call_async(Trigger.Request()))
                next_call = now + _CALL_AGAIN_SECONDS
            return int(phases[f"{unit}.restarts"]) > before and phases[f"{unit}.phase"] in ("up", "given_up")

        one.wait_until(restarted, START_SECONDS, f"{unit} to be up again")
        for future in futures:
            client.remove_pending_request(future)
    if phases[f"{unit}.phase"] != "up":
        raise RestartError(f"{unit}: given up, {phases.get(f'{unit}.last_end', '')}")
    console.print(f"{unit} is up again")
