"""Plays a scenario on a running graph: through the topics, services and parameters that an operator has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dp_msgs.msg import ControllerStatus
from dp_msgs.srv import Advance
from geometry_msgs.msg import PoseStamped, WrenchStamped
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from nav_msgs.msg import Path as PathMessage

from dp_node import RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_tools.clock_reader import ClockReader
from dp_tools.operator_node import Operator
from dp_tools.parameter_service import RemoteParameters
from dp_tools.scenario import Event, Scenario
from marine_model.errors import DpError
from marine_model.frames import BODY_FRAME, MAP_FRAME, heading_to_quaternion

_START_SECONDS = 30.0
_ACKNOWLEDGE_SECONDS = 10.0


class ConductorError(DpError):
    """The graph did not do what the scenario asked; the message says what and why."""


class Conductor:
    """Sails the simulator from event to event; what an event asks is confirmed before time goes on.

    Parameters
    ----------
    operator
        Node to act through.
    scenario
        What to play.
    nodes
        Names of the nodes that must be active.
    """

    def __init__(self, operator: Operator, scenario: Scenario, nodes: tuple[str, ...]) -> None:
        self._operator = operator
        self._scenario = scenario
        self._nodes = nodes
        node = operator.node
        self._advance = node.create_client(Advance, "vessel_sim/advance")
        self._setpoint = node.create_publisher(PoseStamped, "setpoint", RING_PUBLISHER)
        self._joystick = node.create_publisher(WrenchStamped, "joystick", RING_PUBLISHER)
        self._path = node.create_publisher(PathMessage, "path", RING_PUBLISHER)
        self._answers: list[ControllerStatus] = []
        self._parameters: dict[str, RemoteParameters] = {}

    def wait_for_graph(self) -> None:
        """Wait until every node is active. Raises NoAnswerError, naming the one that is not."""
        for name in self._nodes:
            client = self._operator.node.create_client(GetState, f"{name}/get_state")

            def active(client: Any = client, name: str = name) -> bool:
                answer = self._operator.call(client, GetState.Request(), _START_SECONDS, f"the state of {name}")
                return bool(answer.current_state.id == State.PRIMARY_STATE_ACTIVE)

            self._operator.wait_until(active, _START_SECONDS, f"node {name} to become active")
            self._operator.node.destroy_client(client)

    def play(self, progress: Callable[[float], None]) -> None:
        """Play the whole scenario; ``progress`` is told the simulated time (s) now and then.

        Raises
        ------
        ConductorError
            If a node refuses what an event asks.
        NoAnswerError
            If a node does not answer.
        """
        clock = ClockReader()
        try:
            self._play(clock, progress)
        finally:
            clock.close()

    def _play(self, clock: ClockReader, progress: Callable[[float], None]) -> None:
        for event in sorted(self._scenario.events, key=lambda event: event.at):
            self._sail_until(event.at, clock, progress)
            self._perform(event)
        self._sail_until(self._scenario.duration, clock, progress)

    def _sail_until(self, until: float, clock: ClockReader, progress: Callable[[float], None]) -> None:
        if until <= 0.0:
            return
        request = Advance.Request(until=float(until))
        client = self._advance
        self._operator.wait_until(client.service_is_ready, _START_SECONDS, "service vessel_sim/advance")
        future = client.call_async(request)

        def done() -> bool:
            progress(clock.time())
            return bool(future.done())

        self._operator.wait_until(done, None, "the simulator")
        answer = future.result()
        if not answer.success:
            raise ConductorError(f"at {clock.time():.1f} s: vessel_sim: {answer.message}")

    def _perform(self, event: Event) -> None:
        for node, values in event.parameters.items():
            if node not in self._parameters:
                self._parameters[node] = RemoteParameters(self._operator, node)
            self._parameters[node].set(values)
        stamp = max(1, round(event.at * 1e9))  # ns; zero would mean: no input yet
        if event.setpoint is not None:
            self._confirm(self._setpoint, _pose(stamp, event.setpoint), "setpoint", stamp)
        if event.joystick is not None:
            self._confirm(self._joystick, _wrench(stamp, event.joystick), "joystick", stamp)
        if event.path is not None:
            path = PathMessage(poses=[_pose(round(p.at * 1e9), p.position) for p in event.path])
            path.header.frame_id = MAP_FRAME
            path.header.stamp = from_nanoseconds(stamp)
            self._confirm(self._path, path, "setpoint", stamp)

    def _note_status(self, message: ControllerStatus) -> None:
        self._answers.append(message)

    def _confirm(self, publisher: Any, message: Any, kind: str, stamp: int) -> None:
        """Publish an operator input, and wait until the controller says that it has it."""
        node = self._operator.node
        # Only listened to while an acknowledgement is awaited: a conductor must not slow the ring down. Transient local:
        # the controller may have answered before it knows of this subscription.
        subscription = node.create_subscription(
            ControllerStatus, "controller_status", self._note_status, RING_PUBLISHER
        )
        try:
            self._operator.wait_until(
                lambda: publisher.get_subscription_count() > 0 and subscription.get_publisher_count() > 0,
                _START_SECONDS,
                f"dp_controller to listen for a {kind}",
            )
            self._answers.clear()
            publisher.publish(message)

            def confirmed() -> bool:
                for answer in self._answers:
                    if to_nanoseconds(answer.header.stamp) != stamp:
                        continue  # an older one
                    if answer.message.startswith("refused"):
                        raise ConductorError(f"{kind} at {stamp * 1e-9:.1f} s: {answer.message}")
                    if to_nanoseconds(getattr(answer, f"{kind}_stamp")) == stamp:
                        return True
                return False

            self._operator.wait_until(confirmed, _ACKNOWLEDGE_SECONDS, f"dp_controller to accept the {kind}")
        finally:
            node.destroy_subscription(subscription)


def _pose(stamp: int, position: tuple[float, float, float]) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = MAP_FRAME
    message.header.stamp = from_nanoseconds(stamp)
    message.pose.position.x, message.pose.position.y = position[0], position[1]
    _, _, message.pose.orientation.z, message.pose.orientation.w = heading_to_quaternion(position[2])
    return message


def _wrench(stamp: int, force: tuple[float, float, float]) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = BODY_FRAME
    message.header.stamp = from_nanoseconds(stamp)
    message.wrench.force.x, message.wrench.force.y = force[0], force[1]
    message.wrench.torque.z = force[2]
    return message
