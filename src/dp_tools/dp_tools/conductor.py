"""Plays a scenario on a running graph: through the topics, services and parameters that an operator has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from dp_msgs.msg import ControllerStatus
from dp_msgs.srv import Advance
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Vector3, WrenchStamped
from nav_msgs.msg import Path as PathMessage

from dp_bringup.graph_nodes import START_SECONDS
from dp_bringup.operator_node import Operator
from dp_bringup.parameter_service import RemoteParameters
from dp_bringup.supervisor import Supervisor
from dp_bringup.workspace import SIMULATOR_PACKAGE
from dp_node import RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_node.hand_over import hand_over
from dp_tools.clock_reader import ClockReader
from dp_tools.scenario import Event, Scenario
from dp_tools.six_axes import pose_parts, wrench_parts
from marine_model.errors import DpError
from marine_model.frames import BODY_FRAME, MAP_FRAME

_ACKNOWLEDGE_SECONDS = 10.0


class ConductorError(DpError):
    """The graph did not do what the scenario asked; the message says what and why."""


class Conductor:
    """Sails the simulator of an active graph from event to event; what an event asks is confirmed before time goes on.

    Parameters
    ----------
    operator
        Node to act through.
    scenario
        What to play.
    supervisor
        Who looks after the nodes. What an event asks waits until all are up, and a simulator that was started again
        is told anew how far to sail. None: nobody, a node that dies ends the run.
    """

    def __init__(self, operator: Operator, scenario: Scenario, supervisor: Supervisor | None = None) -> None:
        self._supervisor = supervisor
        self._operator = operator
        self._scenario = scenario
        node = operator.node
        self._advance = node.create_client(Advance, "vessel_sim/advance")
        self._setpoint = node.create_publisher(PoseStamped, "setpoint", RING_PUBLISHER)
        self._joystick = node.create_publisher(WrenchStamped, "joystick", RING_PUBLISHER)
        self._path = node.create_publisher(PathMessage, "path", RING_PUBLISHER)
        self._awaited: int | None = None
        self._answers: list[ControllerStatus] = []
        self._parameters: dict[str, RemoteParameters] = {}
        self._reached = 0.0

    def play(self, progress: Callable[[float], None]) -> None:
        """Play the whole scenario; ``progress`` is told the simulated time (s) now and then.

        Raises
        ------
        ConductorError
            If a node refuses what an event asks.
        NoAnswerError
            If a node does not answer.
        """
        clock = ClockReader(self._operator.node)
        try:
            self._play(clock, progress)
            hand_over((self._setpoint, self._joystick, self._path))
        finally:
            clock.close()

    def _play(self, clock: ClockReader, progress: Callable[[float], None]) -> None:
        for event in sorted(self._scenario.events, key=lambda event: event.at):
            self._sail_until(event.at, clock, progress)
            self._wait_for_nodes()
            self._perform(event)
        self._sail_until(self._scenario.duration, clock, progress)

    def _sail_until(self, until: float, clock: ClockReader, progress: Callable[[float], None]) -> None:
        if until <= self._reached:
            return  # several events at one time
        while not self._advance_to(until, clock, progress):
            pass  # by a simulator that has not been told yet
        self._reached = until

    def _advance_to(self, until: float, clock: ClockReader, progress: Callable[[float], None]) -> bool:
        """Sail on; return False if the simulator was started again meanwhile, with time left to sail."""
        client, operator = self._advance, self._operator
        self._wait_for_nodes()
        starts = self._simulator_starts()
        operator.wait_until(client.service_is_ready, START_SECONDS, "service vessel_sim/advance")
        future = client.call_async(Advance.Request(until=float(until)))

        def done() -> bool:
            progress(clock.time())
            return bool(future.done()) or self._simulator_starts() > starts

        operator.wait_until(done, None, "the simulator")
        if not future.done():
            client.remove_pending_request(future)
            return False
        answer = future.result()
        # Time went on while the simulator was away, and may have gone past.
        passed = starts > 0 and answer.reached >= until
        if not (answer.success or passed):
            raise ConductorError(f"at {clock.time():.1f} s: vessel_sim: {answer.message}")
        return True

    def _wait_for_nodes(self) -> None:
        supervisor = self._supervisor
        if supervisor is not None:
            self._operator.wait_until(lambda: supervisor.all_up, None, "the nodes to be up")

    def _simulator_starts(self) -> int:
        return 0 if self._supervisor is None else self._supervisor.restarts(SIMULATOR_PACKAGE)

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
        # Samples have stamps of their own; only the answer to an input carries the stamp of the input.
        if to_nanoseconds(message.header.stamp) == self._awaited:
            self._answers.append(message)

    def _confirm(self, publisher: Any, message: Any, kind: str, stamp: int) -> None:
        """Publish an operator input, and wait until the controller says that it has it."""
        self._operator.wait_until(
            lambda: publisher.get_subscription_count() > 0, START_SECONDS, f"dp_controller to listen for a {kind}"
        )
        self._answers.clear()
        self._awaited = stamp
        # Only while an answer is awaited: a reader in another process costs the ring time. With the history that the
        # controller keeps, as its answer may be out before it has heard of this subscription.
        node = self._operator.node
        subscription = node.create_subscription(
            ControllerStatus, "controller_status", self._note_status, RING_PUBLISHER
        )
        try:
            publisher.publish(message)

            def confirmed() -> bool:
                for answer in self._answers:
                    if to_nanoseconds(getattr(answer, f"{kind}_stamp")) == stamp:
                        return True
                    if answer.message.startswith("refused"):
                        raise ConductorError(f"{kind} at {stamp * 1e-9:.1f} s: {answer.message}")
                return False

            self._operator.wait_until(confirmed, _ACKNOWLEDGE_SECONDS, f"dp_controller to accept the {kind}")
        finally:
            self._awaited = None
            node.destroy_subscription(subscription)


def _pose(stamp: int, position: Sequence[float]) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = MAP_FRAME
    message.header.stamp = from_nanoseconds(stamp)
    point, quaternion = pose_parts(position)
    message.pose.position = Point(**dict(zip("xyz", point, strict=True)))
    message.pose.orientation = Quaternion(**dict(zip("xyzw", quaternion, strict=True)))
    return message


def _wrench(stamp: int, force: Sequence[float]) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = BODY_FRAME
    message.header.stamp = from_nanoseconds(stamp)
    push, turn = wrench_parts(force)
    message.wrench.force = Vector3(**dict(zip("xyz", push, strict=True)))
    message.wrench.torque = Vector3(**dict(zip("xyz", turn, strict=True)))
    return message
