"""The drivers as a ROS 2 node: commands and feedback in, actuator setpoints out."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass
from typing import Any

import numpy as np
from dp_msgs.msg import ActuatorSetpoint, ThrusterFeedback, Ventilation
from dp_msgs.msg import ThrusterCommand as ThrusterCommandMessage
from nav_msgs.msg import Odometry
from numpy.typing import NDArray

from dp_node import (
    Health,
    Inbox,
    RingNode,
    StampSequence,
    WaitingRoom,
    from_nanoseconds,
    run_node,
    to_nanoseconds,
)
from dp_node.stamps import seconds_between
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME
from marine_model.guards import FloatArray, finite_number
from marine_model.vessel import Vessel
from thruster_drivers.command import CommandReader, ThrusterCommand
from thruster_drivers.drivers import SENSOR_LOST, DriverInputs, DriverOutput, Drivers
from thruster_drivers.node_health import Tally, health_of, status_alarm
from thruster_drivers.settings import DriverSettings, check_settings

_ODOMETRY = "odometry"


@dataclass(frozen=True, slots=True)
class _Feedback:
    """A feedback in the order of the vessel file, and the time since the one before, s."""

    stamp: Any
    dt: float
    shaft_speed: FloatArray
    torque: FloatArray
    azimuth: FloatArray
    pitch_ratio: FloatArray | None


class DriversNode(RingNode[DriverSettings]):
    """Answers every thruster_feedback with an actuator_setpoint, every thruster_command with the last one again.

    With codes compensated for the speed it listens to ``odometry``; in lockstep every feedback then waits for the one
    that the command in force answers.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("thruster_drivers", **kwargs)

    def default_settings(self, vessel: Vessel) -> DriverSettings:
        """Return the core's settings with the vessel's numbers, so that the parameters show what is in force."""
        return DriverSettings.for_vessel(vessel)

    def check(self, settings: DriverSettings) -> None:
        """Refuse what does not fit the vessel, such as a law that a thruster cannot follow."""
        check_settings(settings, self.vessel)

    def build(self) -> None:
        """Make core, publisher and subscriptions."""
        self._core = Drivers(self.vessel, self.settings)
        self._reader = CommandReader(self.vessel)
        self._names = list(self.vessel.thruster_names)
        self._none: FloatArray = np.zeros(len(self._names))
        self._publisher = self.publish_on(ActuatorSetpoint, "actuator_setpoint")
        self._detects = self.vessel.drivers.ventilation is not None
        self._ventilation_publisher = self.publish_on(Ventilation, "ventilation") if self._detects else None
        self._surge: Inbox[float] = Inbox(_ODOMETRY)
        self._room: WaitingRoom[_Feedback] = WaitingRoom(0)
        self._forget()
        self._needs_speed = self._hears_speed = False
        self._hear()
        self.listen(ThrusterFeedback, "thruster_feedback", self._on_feedback)
        self.listen(ThrusterCommandMessage, "thruster_command", self._on_command, exclusive=True)

    def apply(self, settings: DriverSettings) -> None:
        """Hand changed settings to the core."""
        self._core.apply(settings)
        self._hear()
        self._answer_held()

    def started(self) -> None:
        """Begin as after the first start: an activation knows no command and no thrust reference."""
        self._core = Drivers(self.vessel, self.settings)
        self._forget()

    def stopped(self) -> None:
        """Leave the motors without torque: nobody will answer their feedback from now on."""
        self._torque = self._azimuth_rate = self._none
        self._code = self._code_at_rest()
        self._room.clear()
        if self._feedback_stamps.last is not None:
            self._publish(self._feedback_stamps.last, stale=True)

    def health(self) -> Health:
        """Return status of the last step and counts."""
        events = self._core.ventilation_events
        waiting = " and ".join(self._room.waits_for(self._needed()))
        if waiting and not self.count_publishers(_ODOMETRY):
            waiting += ", which nobody publishes"
        health = health_of(
            self._tally,
            self.settings.controller,
            self._names,
            None if events is None else events.tolist(),
            self._speed_age if self._needs_speed else None,
            waiting,
        )
        self._tally.reported()
        return health

    def _forget(self) -> None:
        sample = self.vessel.measurement.sample_time
        self._feedback_stamps = StampSequence("thruster_feedback", sample)
        self._command_stamps = StampSequence("thruster_command", sample)
        self._command = ThrusterCommand(self._none, self._none, ())
        self._torque = self._azimuth_rate = self._none
        self._pitch_ratio = self.vessel.pitch_ratio
        self._code = self._code_at_rest()
        self._surge.clear()
        self._room.clear()
        self._speed: tuple[int, float] | None = None  # stamp (ns) and surge speed (m/s) in force
        self._speed_age = math.inf
        self._tally = Tally()

    def _code_at_rest(self) -> NDArray[np.int16]:
        return np.zeros(len(self._names) if self._core.sends_codes else 0, dtype=np.int16)

    def _on_command(self, message: Any) -> None:
        command = self._reader.read(message.name, message.thrust, message.azimuth)
        self._refuse_future(to_nanoseconds(message.header.stamp))
        self._command_stamps.follow(message.header.stamp)  # whether time began anew is for the feedback to say
        self._command = command
        self._tally.commands += 1
        if command.clipped:
            self._tally.clipped += 1
            self._tally.last_clipped = command.clipped
        # The motors' side learns at once which command is in force; torque and rate follow with the next feedback.
        self._publish(to_nanoseconds(message.header.stamp), stale=False)

    def _refuse_future(self, stamp: int) -> None:
        """Refuse a command that is ahead of the feedback: taken, it would make every later one jump back."""
        last, limit = self._feedback_stamps.last, self.settings.command_timeout or self.vessel.drivers.command_timeout
        if last is not None and seconds_between(last, stamp) > limit:
            raise InputError(
                f"thruster_command: expected a time stamp at most {limit} s after the last thruster_feedback, "
                f"at {last * 1e-9:.3f} s, found {stamp * 1e-9:.3f} s"
            )

    def _on_feedback(self, message: Any) -> None:
        order = self._reader.order(message.name)
        shaft_speed = self._reader.in_order("shaft_speed", message.shaft_speed, order)
        torque = self._reader.in_order("torque", message.torque, order)
        azimuth = self._reader.in_order("azimuth", message.azimuth, order)
        # Empty: no thruster has a controllable pitch.
        pitch = self._reader.in_order("pitch_ratio", message.pitch_ratio, order) if message.pitch_ratio else None
        dt = self._feedback_stamps.step(message.header.stamp, self.vessel.simulation.time_step)
        feedback = _Feedback(message.header.stamp, dt, shaft_speed, torque, azimuth, pitch)
        # In lockstep the estimates are the same in every run. Which of them have come is not: that of the command in
        # force is the one that is certain to come, and the newest that there can be.
        command_stamp = self._command_stamps.last
        if self.synchronous and command_stamp is not None and self._room.missing(command_stamp, self._needed()):
            if self._room.holds:
                self.refuse("thruster_feedback: another came before the odometry that this one waited for")
            self._room.hold(command_stamp, feedback)
            return
        self._answer(feedback)

    def _on_odometry(self, message: Any) -> None:
        stamp, found = to_nanoseconds(message.header.stamp), None
        try:
            if message.child_frame_id != BODY_FRAME:
                raise InputError(
                    f"odometry child_frame_id: expected frame '{BODY_FRAME}', found '{message.child_frame_id}'"
                )
            # An invalid observer says so with a negative variance; its numbers are not looked at.
            if not message.pose.covariance[0] < 0.0:
                found = finite_number("odometry twist.linear.x", message.twist.twist.linear.x)
        finally:
            # Refused or not: a feedback that waits is answered, or the ring would stand still.
            self._surge.put(stamp, found)
            self._answer_held()

    def _hear(self) -> None:
        """Listen to the estimate only where a law looks at the speed."""
        self._needs_speed = self.settings.needs_speed(self.vessel)
        if self._needs_speed and not self._hears_speed:
            self._hears_speed = True
            self.listen(Odometry, _ODOMETRY, self._on_odometry, exclusive=True)

    def _needed(self) -> list[Inbox[float]]:
        return [self._surge] if self._needs_speed else []

    def _answer_held(self) -> None:
        held = self._room.release(self._needed())
        if held is not None:
            self._answer(held)

    def _surge_speed(self, stamp: int) -> float | None:
        """Return the surge speed (m/s) in force at a feedback of ``stamp`` (ns); None if it is stale or none has come.

        In force is that of the newest estimate up to then; in lockstep up to the command in force.
        """
        if not self._needs_speed:
            return None
        until = stamp
        if self.synchronous:
            until = min(stamp, self._command_stamps.last or 0)
        self._speed = self._surge.take(until + 1) or self._speed
        self._speed_age = math.inf if self._speed is None else seconds_between(self._speed[0], stamp)
        limit = self.settings.command_timeout or self.vessel.drivers.command_timeout
        return self._speed[1] if self._speed is not None and self._speed_age <= limit else None

    def _answer(self, feedback: _Feedback) -> None:
        stamp = to_nanoseconds(feedback.stamp)
        command_stamp = self._command_stamps.last
        age = math.inf if command_stamp is None else seconds_between(command_stamp, stamp)
        command = self._command
        shaft_speed, torque, azimuth = feedback.shaft_speed, feedback.torque, feedback.azimuth
        inputs = DriverInputs(
            command.thrust,
            command.azimuth,
            age,
            shaft_speed,
            torque,
            azimuth,
            feedback.pitch_ratio,
            self._surge_speed(stamp),
        )
        output = self._core.step(inputs, feedback.dt)
        self._code = output.code
        self._tally.clamped(output.speed_beyond)
        self._torque, self._azimuth_rate, self._pitch_ratio = output.torque, output.azimuth_rate, output.pitch_ratio
        self._tally.command_age = age
        self._tally.feedback += 1
        self._publish(stamp, output.command_stale)
        if self._ventilation_publisher is not None:  # without loss while detection is off: anti-spin waits for it
            self._publish_ventilation(self._ventilation_publisher, feedback.stamp, output)
            if output.ventilating.any():
                flags = output.ventilating.tolist()
                self._tally.ventilated.update([name for name, flag in zip(self._names, flags, strict=True) if flag])
        if output.status != self._tally.status:
            self._report(output)
        if output.status != SENSOR_LOST and not np.isfinite((shaft_speed, torque, azimuth)).all():
            # Nothing is made of it without a command, of torque without detection, but a sensor that is lost is to be
            # known of before it is needed.
            self.refuse(
                f"thruster_feedback: expected finite numbers, found shaft speeds {shaft_speed.tolist()}, torques "
                f"{torque.tolist()} and azimuths {azimuth.tolist()}"
            )

    def _report(self, output: DriverOutput) -> None:
        self._tally.status = output.status
        alarm = status_alarm(output.status)
        if alarm is None:
            self.get_logger().info("nominal")
        else:
            self.get_logger().warning(alarm.text)

    def _publish(self, stamp: int, stale: bool) -> None:
        message = ActuatorSetpoint()
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = BODY_FRAME
        message.command_stamp = from_nanoseconds(self._command_stamps.last or 0)
        message.command_stale = stale
        message.name = self._names
        message.torque = array("d", self._torque.tobytes())
        message.azimuth_rate = array("d", self._azimuth_rate.tobytes())
        message.pitch_ratio = array("d", self._pitch_ratio.tobytes())
        message.code = array("h", self._code.tobytes())
        self._publisher.publish(message)

    def _publish_ventilation(self, publisher: Any, stamp: Any, output: DriverOutput) -> None:
        message = Ventilation()
        message.header.stamp = stamp
        message.header.frame_id = BODY_FRAME
        message.name = self._names
        message.ventilating = output.ventilating.tolist()
        message.beta_q = array("d", output.beta_q.tobytes())
        message.beta_q2 = array("d", output.beta_q2.tobytes())
        publisher.publish(message)


def main() -> None:
    """Run the node until SIGINT or SIGTERM."""
    run_node(DriversNode)
