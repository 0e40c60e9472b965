"""From the graph to the state: subscriptions that count every message and keep the newest as it was sent."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import (
    ActuatorSetpoint,
    AllocationStatus,
    ControllerStatus,
    ObserverState,
    ThrusterCommand,
    ThrusterFeedback,
    Ventilation,
)
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import GetParameters
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from dp_bringup.graph_nodes import NODES
from dp_tools.status.state import OUTPUTS, SHOWN, StatusState
from marine_model import load_vessel
from marine_model.errors import DpError

_KINDS: dict[str, Any] = {
    "odometry": Odometry,
    "observer_state": ObserverState,
    "controller_status": ControllerStatus,
    "tau_desired": WrenchStamped,
    "thruster_command": ThrusterCommand,
    "allocation_status": AllocationStatus,
    "thruster_feedback": ThrusterFeedback,
    "ventilation": Ventilation,
    "wind": Vector3Stamped,
    "pose": PoseWithCovarianceStamped,
    "actuator_setpoint": ActuatorSetpoint,
}
# Best effort: nobody in the ring ever waits for who looks on. In lockstep thousands come between two looks.
_LOOK = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
# From our nodes also what they reported before, for how long an alarm has been active; from others what they send.
_HISTORY = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_REPORTS = QoSProfile(depth=100)


@dataclass(slots=True)
class _Heard:
    """One topic: how many messages came, and the newest if it has not been looked at."""

    total: int = 0
    raw: bytes | None = None


class StatusListener:
    """Fills a state from a node's subscriptions.

    Parameters
    ----------
    node
        In the namespace of the graph; somebody spins it.
    state
        What is filled.
    clock
        Time in s.
    """

    def __init__(self, node: Node, state: StatusState, clock: Callable[[], float]) -> None:
        self._node, self._state, self._clock = node, state, clock
        self._heard = {topic: _Heard() for topic in (*SHOWN, *OUTPUTS.values())}
        for topic, heard in self._heard.items():
            node.create_subscription(_KINDS[topic], topic, _note(heard), _LOOK, raw=True)
        # That one of the two does not fit every publisher is no news.
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        for quality in (_HISTORY, _REPORTS):
            node.create_subscription(DiagnosticArray, "/diagnostics", self._on_report, quality, event_callbacks=silent)
        self._clients = [node.create_client(GetParameters, f"{name}/get_parameters") for name in reversed(NODES)]
        self._asked: Any = None

    def _on_report(self, message: Any) -> None:
        self._state.update("/diagnostics", message, self._clock())

    def look(self) -> None:
        """Hand on what has come since the last look, and ask for the vessel as long as it is unknown."""
        now = self._clock()
        for topic, heard in self._heard.items():
            if heard.raw is not None:
                if topic in SHOWN:
                    self._state.update(topic, deserialize_message(heard.raw, _KINDS[topic]), now)
                heard.raw = None
            if heard.total:
                self._state.count(topic, heard.total, now)
        if self._state.vessel is None:
            self._ask_for_vessel()

    def _ask_for_vessel(self) -> None:
        """Take the vessel that a node has; one whose file is not on this machine stays unknown."""
        if self._asked is None:
            for client in self._clients:
                if client.service_is_ready():
                    self._asked = client.call_async(GetParameters.Request(names=["vessel"]))
                    return
            return
        if not self._asked.done():
            return
        answer, self._asked = self._asked.result(), None
        if answer is not None and answer.values and answer.values[0].string_value:
            try:
                self._state.vessel = load_vessel(answer.values[0].string_value)
            except DpError:
                self._clients.clear()  # asked and not to be had


def _note(heard: _Heard) -> Callable[[bytes], None]:
    def note(raw: bytes) -> None:
        heard.total += 1
        heard.raw = raw

    return note
