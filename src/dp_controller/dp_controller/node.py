"""The controller as a ROS 2 node: odometry and operator inputs in, demands and status out."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from dp_msgs.msg import ControllerStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry, Path

from dp_controller.controller import NOMINAL, Controller
from dp_controller.node_health import Tally, health_of
from dp_controller.settings import ControllerSettings, check_settings
from dp_controller.signals import ControllerInputs, ControllerOutput
from dp_controller.timed_path import TimedPath
from dp_controller.vertical import VerticalInputs
from dp_node import (
    AnswerGate,
    Health,
    Inbox,
    RingNode,
    StampSequence,
    WaitingRoom,
    from_nanoseconds,
    run_node,
    seconds_between,
    to_nanoseconds,
)
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME, MAP_FRAME, quaternion_to_attitude, quaternion_to_heading
from marine_model.guards import FloatArray, finite_vector
from marine_model.vessel import Vessel


class ControllerNode(RingNode[ControllerSettings]):
    """Answers every odometry with one tau_desired and one controller_status, and every operator input with the latter.

    Demands carry the stamp of the odometry they answer. Stamps of joystick and path are on the same time as those of
    odometry; a stamp of zero on a set point or joystick means "on arrival". With wind feed-forward it listens to
    ``wind``; in lockstep every odometry then waits for the wind of its stamp.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("dp_controller", **kwargs)

    def _begin(self) -> None:
        self._core = Controller(self.vessel, self.settings)
        self._gate = AnswerGate(self.synchronous)
        self._stamps = StampSequence("odometry", self.vessel.measurement.sample_time)
        self._operator_stamps: dict[str, int] = {}
        self._acted: int | None = None
        self._began: int | None = None  # stamp of the first estimate
        self._nothing: FloatArray = np.zeros(6) if self.vessel.is_submerged else _NOTHING
        self._achieved: tuple[int | None, FloatArray] = (None, self._nothing)
        self._early_path: Any = None
        self._output: ControllerOutput | None = None
        self._tally = Tally()
        self._setpoint_stamp = 0
        self._joystick_stamp = 0
        self._wind: Inbox[FloatArray] = Inbox(_WIND)
        self._room: WaitingRoom[tuple[int, Callable[[], None]]] = WaitingRoom(0)

    def default_settings(self, vessel: Vessel) -> ControllerSettings:
        """Return the core's settings: gains are the vessel's, scaled by one."""
        return ControllerSettings.for_vessel(vessel)

    def check(self, settings: ControllerSettings) -> None:
        """Refuse feed-forward of a wind that does not blow on this vessel, and axes that it does not control."""
        check_settings(settings, self.vessel)

    def build(self) -> None:
        """Make core, publishers and subscriptions."""
        self._begin()
        self._demands = self.publish_on(WrenchStamped, "tau_desired")
        self._statuses = self.publish_on(ControllerStatus, "controller_status")
        self.listen(Odometry, "odometry", self._on_odometry, exclusive=True)
        self.listen(WrenchStamped, "tau_achieved", self._on_achieved)
        self.listen(PoseStamped, "setpoint", self._on_setpoint)
        self.listen(WrenchStamped, "joystick", self._on_joystick)
        self.listen(Path, "path", self._on_path)
        self._hears_wind = False
        self._hear()

    def apply(self, settings: ControllerSettings) -> None:
        """Hand changed settings to the core, and tell the operator."""
        self._core.apply(settings)
        self._hear()
        self._answer(self._last_stamp)
        self._act_on_held()

    def started(self) -> None:
        """Begin as after the first start: an activation knows no estimate, no operator input and no integral."""
        self._begin()

    def health(self) -> Health:
        """Return mode, safe states and counts."""
        waiting = " and ".join(self._room.waits_for(self._needed()))
        if waiting and not self.count_publishers(_WIND):
            waiting += ", which nobody publishes"
        self._tally.answer, self._tally.held = self._core.message, self._gate.held + self._room.holds
        health = health_of(self._tally, self.settings, waiting)
        self._tally.reported()
        return health

    # Estimates ------------------------------------------------------------------------------------------------------

    def _on_odometry(self, message: Any) -> None:
        _require_frame("odometry", message.header.frame_id, MAP_FRAME)
        _require_frame("odometry child_frame_id", message.child_frame_id, BODY_FRAME)
        # An invalid observer says so with a negative variance; its numbers are not looked at.
        valid = not message.pose.covariance[0] < 0.0
        position = velocity = _NOTHING
        below: VerticalInputs | None = None
        if valid:
            position = _pose("odometry", message.pose.pose)
            twist = message.twist.twist
            velocity = finite_vector("odometry twist", (twist.linear.x, twist.linear.y, twist.angular.z), 3)
            if self.vessel.is_submerged:
                below = _below("odometry", message.pose.pose, twist)
        stamp = to_nanoseconds(message.header.stamp)
        dt = self._stamps.step(message.header.stamp, self.vessel.measurement.sample_time)
        act = partial(self._act, stamp, dt, position, velocity, valid, below)
        # In lockstep what was measured is the same in every run, so that the estimate waits for it.
        if self.synchronous and self._room.missing(stamp, self._needed()):
            if self._room.holds:
                self.refuse("odometry: another came before the wind that this one waited for")
            self._room.hold(stamp, (stamp, act))
            return
        self._gate.submit(stamp, act)

    def _on_wind(self, message: Any) -> None:
        stamp = to_nanoseconds(message.header.stamp)
        found = None
        try:
            _require_frame(_WIND, message.header.frame_id, BODY_FRAME)
            found = finite_vector(_WIND, (message.vector.x, message.vector.y), 2)
        finally:
            # Refused or not: an estimate that waits is answered, or the ring would stand still.
            self._wind.put(stamp, found)
            self._act_on_held()

    def _act_on_held(self) -> None:
        held = self._room.release(self._needed())
        if held is not None:
            self._gate.submit(*held)

    def _needed(self) -> list[Inbox[FloatArray]]:
        return [self._wind] if self._core.settings.wind_feedforward.enabled else []

    def _hear(self) -> None:
        """Listen to the wind where it is needed only."""
        if not self._hears_wind and self._core.settings.wind_feedforward.enabled:
            self._hears_wind = True
            self.listen(Vector3Stamped, _WIND, self._on_wind)

    def _on_achieved(self, message: Any) -> None:
        stamp = to_nanoseconds(message.header.stamp)
        try:
            _require_frame("tau_achieved", message.header.frame_id, BODY_FRAME)
            self._achieved = (stamp, self._force("tau_achieved", message.wrench))
        finally:
            # Refused or not, the allocator has answered: the next sample must not wait for ever.
            self._gate.answer(stamp)

    def _force(self, what: str, wrench: Any) -> FloatArray:
        """Return surge, sway and yaw of a wrench; all six of a submerged vehicle's."""
        return _wrench6(what, wrench) if self.vessel.is_submerged else _wrench(what, wrench)

    def _act(
        self,
        stamp: int,
        dt: float,
        position: FloatArray,
        velocity: FloatArray,
        valid: bool,
        below: VerticalInputs | None,
    ) -> None:
        answered, achieved = self._achieved
        if self._acted is None and self._early_path is not None:
            self._core.set_path(*_timed_poses(self._early_path, stamp, 0.0))
        if self._acted is not None and answered != self._acted:
            self._tally.unanswered += 1
        tau_achieved = achieved if answered == self._acted else None
        if self._began is None:
            self._began = stamp
        if stamp - (self._began if answered is None else answered) > self.vessel.drivers.command_timeout * 1e9:
            tau_achieved = self._nothing  # no allocator for so long: the drivers have stopped the thrusters
        if below is not None and tau_achieved is not None:
            below = replace(below, achieved=tau_achieved[2:5])
        if tau_achieved is not None and len(tau_achieved) == 6:
            tau_achieved = tau_achieved[_PLANE]
        # The newest up to the estimate's own stamp; what has been used grows old in the core.
        wind = self._wind.take(stamp + 1)
        measured = None if wind is None else wind[1]
        output = self._core.step(ControllerInputs(position, velocity, tau_achieved, valid, measured, below), dt)
        self._output, self._acted = output, stamp
        before = self._tally.status
        surge, sway, yaw = output.error.tolist()
        below_error = None if output.vertical is None else output.vertical.error.tolist()
        self._tally.acted(output.status, (surge, sway, yaw), below_error)
        if output.status != before:
            if output.status == NOMINAL:
                self.get_logger().info("status: nominal")
            else:
                self.get_logger().warning(f"status: {output.status}")
        self._publish_demand(stamp, output)
        self._publish_status(stamp)

    # Operator -------------------------------------------------------------------------------------------------------

    def _on_setpoint(self, message: Any) -> None:
        self._take("set point", message.header, MAP_FRAME, partial(self._set_setpoint, message))

    def _on_joystick(self, message: Any) -> None:
        self._take("joystick", message.header, BODY_FRAME, partial(self._set_joystick, message))

    def _on_path(self, message: Any) -> None:
        self._take("path", message.header, MAP_FRAME, partial(self._set_path, message))

    def _take(self, what: str, header: Any, frame: str, use: Callable[[int], None]) -> None:
        """Hand an operator input on; answer it with a status whether it is accepted or refused."""
        given = to_nanoseconds(header.stamp)
        stamp = given if given else self._last_stamp
        try:
            _require_frame(what, header.frame_id, frame)
            last = self._operator_stamps.get(what, 0)
            if stamp < last:
                raise InputError(
                    f"{what}: expected a time stamp of at least {last * 1e-9:.3f} s, found {stamp * 1e-9:.3f} s"
                )
            use(stamp)
            self._operator_stamps[what] = stamp
        except InputError as error:
            self._core.answer(f"refused: {error}")
            raise
        finally:
            self._answer(stamp)

    def _set_setpoint(self, message: Any, stamp: int) -> None:
        self._stamps.check_ahead("set point", stamp)
        pose = _pose("set point", message.pose)
        if self.vessel.is_submerged:
            depth, roll, pitch = _tilt("set point", message.pose)
            pose = np.array((pose[0], pose[1], depth, roll, pitch, pose[2]))
        self._core.set_setpoint(pose)
        self._setpoint_stamp = stamp

    def _set_joystick(self, message: Any, stamp: int) -> None:
        time = None if self._acted is None else self._core.time + seconds_between(self._acted, stamp)
        self._core.set_joystick(self._force("joystick", message.wrench), time)
        self._joystick_stamp = stamp

    def _set_path(self, message: Any, stamp: int) -> None:
        self._stamps.check_ahead("path", stamp)
        if self._acted is not None:
            self._core.set_path(*_timed_poses(message, self._acted, self._core.time))
        else:
            # Its times cannot be told before there is a time: checked now, taken with the first estimate.
            path = TimedPath(*_timed_poses(message, stamp, 0.0))
            self._early_path = message
            self._core.answer(f"accepted: path of {len(path)} poses; waits for odometry")
        self._setpoint_stamp = stamp

    # Messages -------------------------------------------------------------------------------------------------------

    @property
    def _last_stamp(self) -> int:
        """Stamp of the last odometry, ns; 0 before the first."""
        return self._stamps.last or 0

    def _publish_demand(self, stamp: int, output: ControllerOutput) -> None:
        message = WrenchStamped()
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = BODY_FRAME
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, torque.z = output.tau_desired.tolist()
        if output.vertical is not None:
            force.z, torque.x, torque.y = output.vertical.tau_desired.tolist()
        self._demands.publish(message)

    def _answer(self, stamp: int) -> None:
        """Publish the status between two samples, as the answer to an operator."""
        if self.active:
            self._publish_status(stamp)

    def _publish_status(self, stamp: int) -> None:
        output, settings = self._output, self._core.settings
        message = ControllerStatus()
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = BODY_FRAME
        message.mode = settings.mode
        message.axis_mode = list(self._core.axis_modes)
        message.status = self._tally.status
        message.message = self._core.message
        message.setpoint_stamp = from_nanoseconds(self._setpoint_stamp)
        message.joystick_stamp = from_nanoseconds(self._joystick_stamp)
        if output is not None:
            message.reference_position = output.reference_position
            message.reference_velocity = output.reference_velocity
            message.error = output.error
            message.proportional = output.proportional
            message.integral = output.integral
            message.derivative = output.derivative
            message.wind_feedforward = output.wind_feedforward
            message.joystick = output.joystick
            message.transfer = output.transfer
        modes = self._core.vertical_modes
        if modes is not None:
            message.vertical_axis_mode = list(modes)
            below = None if output is None else output.vertical
            for name in _BELOW:
                values = _NOTHING if below is None else getattr(below, name)
                setattr(message, f"vertical_{name}", array("d", values.tobytes()))
        self._statuses.publish(message)


_WIND = "wind"
_NOTHING: FloatArray = np.zeros(3)
_NOTHING.setflags(write=False)
_PLANE = [0, 1, 5]  # surge, sway, yaw among six
# Fields of VerticalOutput that a status carries.
_BELOW = ("reference", "error", "proportional", "integral", "derivative", "joystick", "transfer")


def _require_frame(what: str, found: str, expected: str) -> None:
    if found != expected:
        raise InputError(f"{what}: expected frame '{expected}', found '{found}'")


def _pose(what: str, pose: Any) -> FloatArray:
    """Return north, east, heading of a geometry_msgs/Pose."""
    orientation = pose.orientation
    plane = (pose.position.x, pose.position.y)
    if not all(map(math.isfinite, plane)):
        raise InputError(f"{what}: expected finite numbers, found {list(plane)}")
    try:
        heading = quaternion_to_heading(orientation.x, orientation.y, orientation.z, orientation.w)
    except InputError as error:
        raise InputError(f"{what} {error}") from error
    return np.array((*plane, heading))


def _tilt(what: str, pose: Any) -> tuple[float, float, float]:
    """Return depth, roll and pitch of a geometry_msgs/Pose whose quaternion is checked."""
    orientation = pose.orientation
    roll, pitch, _ = quaternion_to_attitude(orientation.x, orientation.y, orientation.z, orientation.w)
    depth, roll, pitch = finite_vector(what, (pose.position.z, roll, pitch), 3).tolist()
    return depth, roll, pitch


def _below(what: str, pose: Any, twist: Any) -> VerticalInputs:
    """Return depth, roll and pitch and their rates."""
    rates = (twist.linear.z, twist.angular.x, twist.angular.y)
    return VerticalInputs(np.array(_tilt(what, pose)), finite_vector(f"{what} twist", rates, 3))


def _wrench6(what: str, wrench: Any) -> FloatArray:
    """Return all six elements of a geometry_msgs/Wrench."""
    force, torque = wrench.force, wrench.torque
    return finite_vector(what, (force.x, force.y, force.z, torque.x, torque.y, torque.z), 6)


def _wrench(what: str, wrench: Any) -> FloatArray:
    """Return surge, sway and yaw of a geometry_msgs/Wrench."""
    return finite_vector(what, (wrench.force.x, wrench.force.y, wrench.torque.z), 3)


def _timed_poses(message: Any, stamp: int, time: float) -> tuple[list[float], list[FloatArray]]:
    """Return times and positions of a nav_msgs/Path; ``stamp`` (ns) is ``time`` (s) on the controller's clock."""
    times, positions = [], []
    for i, pose in enumerate(message.poses):
        # A pose that names no frame is in that of the path.
        if pose.header.frame_id:
            _require_frame(f"path pose {i}", pose.header.frame_id, MAP_FRAME)
        times.append(time + seconds_between(stamp, to_nanoseconds(pose.header.stamp)))
        positions.append(_pose(f"path pose {i}", pose.pose))
    if not positions:
        raise InputError("path: expected at least one pose, found none")
    return times, positions


def main() -> None:
    """Run the node until SIGINT or SIGTERM."""
    run_node(ControllerNode)
