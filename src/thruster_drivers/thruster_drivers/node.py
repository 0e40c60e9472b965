"""The drivers as a ROS 2 node: commands and feedback in, actuator setpoints out."""

from __future__ import annotations

import math
from array import array
from typing import Any

import numpy as np
from dp_msgs.msg import ActuatorSetpoint, ThrusterFeedback, Ventilation
from dp_msgs.msg import ThrusterCommand as ThrusterCommandMessage

from dp_node import Health, RingNode, StampSequence, from_nanoseconds, run_node, to_nanoseconds
from dp_node.stamps import seconds_between
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from thruster_drivers.command import CommandReader, ThrusterCommand
from thruster_drivers.drivers import SENSOR_LOST, DriverInputs, DriverOutput, Drivers
from thruster_drivers.node_health import Tally, health_of, status_alarm
from thruster_drivers.settings import DriverSettings, check_settings


class DriversNode(RingNode[DriverSettings]):
    """Answers every thruster_feedback with an actuator_setpoint, every thruster_command with the last one again."""

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
        self._forget()
        self.listen(ThrusterFeedback, "thruster_feedback", self._on_feedback)
        self.listen(ThrusterCommandMessage, "thruster_command", self._on_command, exclusive=True)

    def apply(self, settings: DriverSettings) -> None:
        """Hand changed settings to the core."""
        self._core.apply(settings)

    def started(self) -> None:
        """Begin as after the first start: an activation knows no command and no thrust reference."""
        self._core = Drivers(self.vessel, self.settings)
        self._forget()

    def stopped(self) -> None:
        """Leave the motors without torque: nobody will answer their feedback from now on."""
        self._torque = self._azimuth_rate = self._none
        if self._feedback_stamps.last is not None:
            self._publish(self._feedback_stamps.last, stale=True)

    def health(self) -> Health:
        """Return status of the last step and counts."""
        events = self._core.ventilation_events
        health = health_of(
            self._tally, self.settings.controller, self._names, None if events is None else events.tolist()
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
        self._tally = Tally()

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
        stamp = to_nanoseconds(message.header.stamp)
        command_stamp = self._command_stamps.last
        age = math.inf if command_stamp is None else seconds_between(command_stamp, stamp)
        command = self._command
        output = self._core.step(
            DriverInputs(command.thrust, command.azimuth, age, shaft_speed, torque, azimuth, pitch), dt
        )
        self._torque, self._azimuth_rate, self._pitch_ratio = output.torque, output.azimuth_rate, output.pitch_ratio
        self._tally.command_age = age
        self._tally.feedback += 1
        self._publish(stamp, output.command_stale)
        if self._ventilation_publisher is not None:  # without loss while detection is off: anti-spin waits for it
            self._publish_ventilation(self._ventilation_publisher, message.header.stamp, output)
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
