"""The simulated vessel as a ROS 2 node: publishes measurements, and makes time go on."""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Callable
from enum import Enum
from typing import Any

# The core loads these where it first needs them; a sea or a wind that begins while running shall not wait for that.
import scipy.integrate
import scipy.interpolate
import scipy.special  # noqa: F401
from dp_msgs.msg import ActuatorSetpoint, PropulsionTruth, ThrusterFeedback
from dp_msgs.srv import Advance
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from dp_node import DpNode, Health, from_nanoseconds, run_node, to_nanoseconds
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME, MAP_FRAME, attitude_to_quaternion, heading_to_quaternion
from marine_model.guards import FloatArray, finite_vector
from vessel_sim.interface import SimulatorInputs
from vessel_sim.make_simulator import make_simulator
from vessel_sim.node_health import SimulatorState, health_of
from vessel_sim.pace import Pace
from vessel_sim.settings import check_settings
from vessel_sim.time_settings import NodeSettings

_WATCH_PERIOD = 0.1  # s of wall time between two looks at the graph and at answers that are overdue
# The graph must look complete this many times in a row before lockstep starts: one node may see a new endpoint
# before another does.
_SIGHTINGS = 3
_BURST = 10  # steps in one go when behind; messages get their turn in between

# Topics between pose and actuator_setpoint, in the order in which data travels.
_CHAIN = ("odometry", "tau_desired", "tau_achieved", "thruster_command")
# Who listens to one of these may wait for it, and many a graph does without. Time begins all the same; where the ring
# stands still, they are named.
_ASIDE = ("ventilation",)


class Phase(Enum):
    """What happens next, and what it waits for."""

    GRAPH = "waiting for the graph"
    HELD = "held"
    PACED = "waiting for its time"
    COMMAND = "waiting for an actuator_setpoint that holds the command for the pose"
    SETPOINT = "waiting for the actuator_setpoint that answers the thruster_feedback"


class VesselSimNode(DpNode[NodeSettings]):
    """Node ``vessel_sim``."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("vessel_sim", **kwargs)

    def default_settings(self, vessel: Vessel) -> NodeSettings:
        """Return the settings that hold when no parameter overrides them."""
        return NodeSettings.for_vessel(vessel)

    def check(self, settings: NodeSettings) -> None:
        """Refuse settings that do not fit the vessel."""
        check_settings(settings, self.vessel)

    @property
    def in_lockstep(self) -> bool:
        """Answers sent before the drivers knew this node as well, in lockstep: it waits for each of them."""
        return self.settings.lockstep

    def build(self) -> None:
        """Make the core at simulated time 0, and its topics."""
        vessel = self.vessel
        self._simulator = make_simulator(vessel, self.settings)
        self._n = len(vessel.thrusters)
        self._time_step = vessel.simulation.time_step
        self._step_ns = round(self._time_step * 1e9)
        self._control_every = round(vessel.measurement.sample_time / self._time_step)
        # At a control sample: the first thing that is sent is a pose.
        self._tick = math.ceil(self.settings.start_time / vessel.measurement.sample_time) * self._control_every
        self._inputs = self._rest = SimulatorInputs(
            *(finite_vector("zero", [0.0] * self._n, self._n) for _ in range(2))
        )
        self._began = self._now_ns
        self._fed = self._tick  # when the set point in force came
        self._drives_cut = 0
        self._phase = Phase.GRAPH if self.settings.lockstep else Phase.PACED
        self._sightings = 0
        self._waiting_since = 0.0
        self._reported = False
        self._answered: tuple[int, int] | None = None  # stamps of the last actuator_setpoint, ns
        self._poses = self._poses_lost = self._poses_reported = self._lost_reported = 0
        self._target: int | None = None  # tick to sail to while holding
        self._reply: Callable[[Advance.Response], None] | None = None
        self._pace = Pace(self.settings.rate)

        self._make_messages()
        self._publish_pose = self.publish_on(PoseWithCovarianceStamped, "pose")
        # Where nobody knows what the wind does to the vessel, it does not blow.
        self._publish_wind = None if vessel.wind_forces is None else self.publish_on(Vector3Stamped, "wind")
        self._publish_feedback = self.publish_on(ThrusterFeedback, "thruster_feedback")
        self._publish_clock = self.publish_on(Clock, "clock")  # /clock, unless in a namespace
        self._publish_truth = self.publish_on(Odometry, "truth")
        self._publish_environment = self.publish_on(WrenchStamped, "environment_force")
        self._publish_propulsion = self.publish_on(PropulsionTruth, "propulsion_truth")
        self.listen(ActuatorSetpoint, "actuator_setpoint", self._on_setpoint, exclusive=True)
        self._setpoints = next(s for s in self.subscriptions if s.topic_name.endswith("/actuator_setpoint"))
        answer_later(self.create_service(Advance, "~/advance", _take_over), self._on_advance)
        self.create_timer(_WATCH_PERIOD, self._watch)
        self._pacer = self.create_timer(1.0, self._on_time)
        self._set_pacer()

    def apply(self, settings: NodeSettings) -> None:
        """Hand changed settings to the core."""
        self._simulator.apply(settings)
        if settings.rate != self._pace.rate:
            self._pace.rate = settings.rate
            self._pace.restart(time.monotonic(), self._now)
            self._set_pacer()
            if self.active and self._phase is Phase.PACED and settings.lockstep:
                self._begin_tick()

    def started(self) -> None:
        """Begin, or go on where an earlier activation ended."""
        if self._phase in (Phase.COMMAND, Phase.SETPOINT):
            # The answer went by while inactive. Every stamp is used once: finish this tick on what there is.
            self._step()
        self._sightings = 0
        self._enter(Phase.GRAPH if self.settings.lockstep else Phase.PACED)
        self._pace.restart(time.monotonic(), self._now)

    def stopped(self) -> None:
        """Answer who waits for time to go on."""
        self._finish_advance(False, "vessel_sim was deactivated")

    # Time -----------------------------------------------------------------------------------------------------------

    @property
    def _now(self) -> float:
        """Simulated time, s."""
        return self._tick * self._step_ns * 1e-9

    @property
    def _now_ns(self) -> int:
        return self._tick * self._step_ns

    def _enter(self, phase: Phase) -> None:
        self._phase = phase
        self._waiting_since = time.monotonic()
        self._reported = False

    def _set_pacer(self) -> None:
        """Let the timer tick at the rate of the steps, but no faster than a timer is good for."""
        rate = self.settings.rate
        if rate == 0.0:
            self._pacer.cancel()
            return
        self._pacer.timer_period_ns = max(1_000_000, round(self._step_ns / rate))
        self._pacer.reset()

    def _on_time(self) -> None:
        if not self.active or self._phase is not Phase.PACED:
            return
        if self.settings.lockstep:
            self._begin_tick()
            return
        wall = time.monotonic()
        for _ in range(_BURST):
            if not self._pace.allows(wall, self._now) or not self._may_sail():
                break
            if self._tick % self._control_every == 0:
                self._send_pose()
            self._send_feedback()
            self._step()
        self._pace.note(wall, self._now)

    def _may_sail(self) -> bool:
        """Return whether time may go on; answer an advance that has come to its end."""
        if not self.settings.hold:
            return True
        if self._target is not None and self._tick < self._target:
            return True
        self._enter(Phase.HELD)
        self._finish_advance(True, "")
        return False

    def _step(self) -> None:
        """One step of the core on the set point in force."""
        if not self.settings.lockstep:
            self._watch_drives()
        self._simulator.step(self._inputs, self._time_step)
        self._tick += 1
        self._clock_message.clock = from_nanoseconds(self._now_ns)
        self._publish_clock.publish(self._clock_message)

    def _watch_drives(self) -> None:
        """Take torque and azimuth rate away once set points have stopped, as the watchdog of a motor drive does."""
        timeout = self.settings.setpoint_timeout
        if timeout == 0.0 or self._inputs is self._rest or (self._tick - self._fed) * self._time_step <= timeout:
            return
        self._inputs = self._rest
        self._drives_cut += 1
        self.get_logger().warning(f"no actuator_setpoint for {timeout:g} s: drives without torque and azimuth rate")

    # Lockstep -------------------------------------------------------------------------------------------------------

    def _begin_tick(self) -> None:
        if not self._may_sail():
            return
        wall = time.monotonic()
        self._pace.note(wall, self._now)
        if not self._pace.allows(wall, self._now):
            self._enter(Phase.PACED)
        elif self._tick % self._control_every == 0:
            # The phase first: in principle the answer may come before the call that asks has returned.
            self._enter(Phase.COMMAND)
            self._send_pose()
        else:
            self._ask_drivers()

    def _ask_drivers(self) -> None:
        self._enter(Phase.SETPOINT)
        self._send_feedback()

    def _on_setpoint(self, message: ActuatorSetpoint) -> None:
        expected = list(self.vessel.thruster_names)
        if list(message.name) != expected:
            raise InputError(f"actuator_setpoint.name: expected {expected}, found {list(message.name)}")
        torque = finite_vector("actuator_setpoint.torque", message.torque, self._n)
        rate = finite_vector("actuator_setpoint.azimuth_rate", message.azimuth_rate, self._n)
        # Empty: from drivers that know of no pitch.
        pitch = None
        if message.pitch_ratio:
            pitch = finite_vector("actuator_setpoint.pitch_ratio", message.pitch_ratio, self._n)
            self._simulator.check_pitch(pitch)
        stamp, command_stamp = to_nanoseconds(message.header.stamp), to_nanoseconds(message.command_stamp)
        now = self._now_ns
        if self.settings.lockstep and max(stamp, command_stamp) > now:
            raise InputError(
                f"actuator_setpoint: expected stamps up to {self._now:.3f} s, "
                f"found {max(stamp, command_stamp) * 1e-9:.3f} s"
            )
        self._answered = (stamp, command_stamp)
        self._inputs = SimulatorInputs(torque, rate, pitch)
        self._fed = self._tick
        if self._phase is Phase.COMMAND:
            if command_stamp >= now:
                self._ask_drivers()
        elif self._phase is Phase.SETPOINT and stamp == now:
            self._step()
            self._begin_tick()

    # The graph and what is missing ----------------------------------------------------------------------------------

    def _missing(self) -> list[str]:
        """Return what the ring lacks, in words; empty if it is closed.

        A topic of the chain that neither has a publisher nor a subscriber belongs to no node that is there.
        """
        missing = [
            f"nobody listens to {publisher.topic_name}"
            for publisher in (self._publish_pose, self._publish_feedback)
            if publisher.get_subscription_count() == 0
        ]
        for topic in _CHAIN:
            sources, sinks = self.count_publishers(topic), self.count_subscribers(topic)
            if sources == 0 and sinks > 0:
                missing.append(f"nobody publishes {topic}")
            if sinks == 0 and sources > 0:
                missing.append(f"nobody listens to {topic}")
        if self._setpoints.get_publisher_count() == 0:
            missing.append(f"nobody publishes {self._setpoints.topic_name}")
        return missing

    def _watch(self) -> None:
        if not self.active:
            return
        if self._phase is Phase.GRAPH:
            self._sightings = 0 if self._missing() else self._sightings + 1
            if self._sightings >= _SIGHTINGS:
                self._pace.restart(time.monotonic(), self._now)
                self._begin_tick()
                return
        if not self._reported and self._is_overdue():
            self._reported = True
            self.get_logger().error(self._complaint())

    def _is_overdue(self) -> bool:
        if self._phase not in (Phase.GRAPH, Phase.COMMAND, Phase.SETPOINT):
            return False
        return time.monotonic() - self._waiting_since > self.settings.lockstep_timeout

    def _complaint(self) -> str:
        """Return who has not answered, as far as this node can see."""
        waited = time.monotonic() - self._waiting_since
        text = f"lockstep at {self._now:.3f} s: {self._phase.value} for {waited:.1f} s"
        if self._answered is None:
            text += "; no actuator_setpoint so far"
        else:
            stamp, command = (f"{ns * 1e-9:.3f} s" for ns in self._answered)
            text += f"; the last actuator_setpoint answers {stamp} and holds the command for {command}"
        missing = self._missing()
        missing += [
            f"nobody publishes {topic}"
            for topic in _ASIDE
            if self.count_subscribers(topic) > 0 and self.count_publishers(topic) == 0
        ]
        return f"{text}; {', '.join(missing) if missing else 'every topic of the ring has both ends'}"

    def health(self) -> Health:
        """Return how time goes, and who keeps it from going."""
        answered = self._began if self._answered is None else self._answered[0]
        state = SimulatorState(
            now=self._now,
            phase=self._phase.value,
            rate=self.settings.rate,
            achieved=self._pace.achieved,
            paced=self._phase is Phase.PACED,
            held=self._phase is Phase.HELD,
            overdue=self._complaint() if self._is_overdue() else "",
            forgiven=self._pace.forgiven,
            poses=self._poses,
            poses_lost=self._poses_lost,
            fresh_poses=self._poses - self._poses_reported,
            fresh_lost=self._poses_lost - self._lost_reported,
            setpoint_age=(self._now_ns - answered) * 1e-9,
            setpoint_limit=self.vessel.drivers.command_timeout,
            drives_cut=self._drives_cut,
        )
        self._poses_reported, self._lost_reported = self._poses, self._poses_lost
        return health_of(state)

    # Service --------------------------------------------------------------------------------------------------------

    def _on_advance(self, request: Advance.Request, reply: Callable[[Advance.Response], None]) -> None:
        refusal = self._why_not_advance(float(request.until))
        if refusal:
            reply(Advance.Response(success=False, message=refusal, reached=self._now))
            return
        self._reply = reply
        # A tick that is due at `until` but for rounding is the target; otherwise the next one.
        self._target = math.ceil(request.until / self._time_step - 1e-6)
        if self._phase is Phase.HELD:
            self._pace.restart(time.monotonic(), self._now)
            if self.settings.lockstep:
                self._begin_tick()
            else:
                self._enter(Phase.PACED)

    def _why_not_advance(self, until: float) -> str:
        if not self.settings.hold:
            return "hold: expected true, so that somebody else than the clock makes time go on, found false"
        if not self.active:
            return "vessel_sim is not active"
        if self._reply is not None:
            return f"an advance to tick {self._target} ({self._time_step} s each) is under way"
        if not math.isfinite(until) or until <= self._now:
            return f"until: expected a finite time after {self._now:.3f} s, found {until}"
        return ""

    def _finish_advance(self, success: bool, message: str) -> None:
        reply, self._reply, self._target = self._reply, None, None
        if reply is not None:
            reply(Advance.Response(success=success, message=message, reached=self._now))

    # Messages -------------------------------------------------------------------------------------------------------

    def _make_messages(self) -> None:
        """Make the messages once; only what changes is set later."""
        data = self.vessel.measurement
        self._pose = PoseWithCovarianceStamped()
        self._pose.header.frame_id = MAP_FRAME
        covariance = [0.0] * 36
        covariance[7], covariance[35] = data.position_noise**2, data.heading_noise**2
        covariance[14], covariance[21] = data.depth_noise**2, data.attitude_noise**2
        covariance[28] = covariance[21]
        self._pose.pose.covariance = covariance
        start = self.settings.initial
        self._set_pose(self._pose.pose.pose, start.north, start.east, start.heading)
        self._pose.pose.pose.position.z = start.depth
        self._wind = Vector3Stamped()
        self._wind.header.frame_id = BODY_FRAME
        self._feedback = ThrusterFeedback(name=list(self.vessel.thruster_names))
        self._feedback.header.frame_id = BODY_FRAME
        self._clock_message = Clock()
        self._truth = Odometry(child_frame_id=BODY_FRAME)
        self._truth.header.frame_id = MAP_FRAME
        self._environment = WrenchStamped()
        self._environment.header.frame_id = BODY_FRAME
        self._propulsion = PropulsionTruth(name=list(self.vessel.thruster_names))
        self._propulsion.header.frame_id = BODY_FRAME

    @staticmethod
    def _set_pose(pose: Any, north: float, east: float, heading: float) -> None:
        pose.position.x, pose.position.y = float(north), float(east)
        _, _, pose.orientation.z, pose.orientation.w = heading_to_quaternion(heading)

    @staticmethod
    def _set_pose_in_six(
        pose: Any, north: float, east: float, depth: float, roll: float, pitch: float, heading: float
    ) -> None:
        pose.position.x, pose.position.y, pose.position.z = north, east, depth
        q = pose.orientation
        q.x, q.y, q.z, q.w = attitude_to_quaternion(roll, pitch, heading)

    def _send_pose(self) -> None:
        """Publish truth and measurement; a lost measurement is the last one, marked by covariance[0] = -1."""
        stamp = from_nanoseconds(self._now_ns)
        self._send_truth(stamp)
        self._send_wind(stamp)
        measured = self._simulator.measure()
        message = self._pose
        message.header.stamp = stamp
        self._poses += 1
        if measured is None:
            self._poses_lost += 1
            message.pose.covariance[0] = -1.0
        else:
            message.pose.covariance[0] = self.vessel.measurement.position_noise**2
            set_pose = self._set_pose_in_six if self.vessel.is_submerged else self._set_pose
            set_pose(message.pose.pose, *measured.tolist())
        self._publish_pose.publish(message)

    def _send_wind(self, stamp: Any) -> None:
        measured = self._simulator.measure_wind()
        if self._publish_wind is None or measured is None:
            return
        message = self._wind
        message.header.stamp = stamp
        message.vector.x, message.vector.y = measured.tolist()
        self._publish_wind.publish(message)

    def _send_truth(self, stamp: Any) -> None:
        truth = self._simulator.truth()
        message = self._truth
        message.header.stamp = stamp
        north, east, heading = (truth.position + truth.wave_position).tolist()
        self._set_pose(message.pose.pose, north, east, heading)
        u, v, r = truth.velocity.tolist()
        w_north, w_east, w_yaw = truth.wave_velocity.tolist()
        c, s = math.cos(truth.position[2]), math.sin(truth.position[2])
        low = complex(u, v) * complex(c, s)  # over ground, north + i east
        c, s = math.cos(heading), math.sin(heading)
        total = (low + complex(w_north, w_east)) * complex(c, -s)
        twist = message.twist.twist
        twist.linear.x, twist.linear.y, twist.angular.z = total.real, total.imag, r + w_yaw
        if truth.vertical_position is not None and truth.vertical_velocity is not None:
            depth, roll, pitch = truth.vertical_position.tolist()
            self._set_pose_in_six(message.pose.pose, north, east, depth, roll, pitch, heading)
            twist.linear.z, twist.angular.x, twist.angular.y = truth.vertical_velocity.tolist()
        self._publish_truth.publish(message)

        force = (truth.wave_force + truth.current_force + truth.wind_force).tolist()
        wrench = self._environment.wrench
        self._environment.header.stamp = stamp
        wrench.force.x, wrench.force.y, wrench.torque.z = force
        if truth.current_force6 is not None:  # all there is below the surface
            _, _, wrench.force.z, wrench.torque.x, wrench.torque.y, _ = truth.current_force6.tolist()
        self._publish_environment.publish(self._environment)

        propulsion = self._propulsion
        propulsion.header.stamp = stamp
        propulsion.thrust = _doubles(truth.thrust)
        propulsion.thrust_loss = _doubles(truth.thrust_loss)
        propulsion.torque_loss = _doubles(truth.torque_loss)
        propulsion.submergence = _doubles(truth.submergence)
        propulsion.advance_speed = _doubles(truth.advance_speed)
        self._publish_propulsion.publish(propulsion)

    def _send_feedback(self) -> None:
        output = self._simulator.output
        message = self._feedback
        message.header.stamp = from_nanoseconds(self._now_ns)
        message.shaft_speed = _doubles(output.shaft_speed)
        message.torque = _doubles(output.torque)
        message.power = _doubles(output.power)
        message.azimuth = _doubles(output.azimuth)
        message.azimuth_rate = _doubles(output.azimuth_rate)
        message.pitch_ratio = _doubles(output.pitch_ratio)
        self._publish_feedback.publish(message)


def _doubles(values: FloatArray) -> array[float]:
    """Return what a float64[] field takes without looking at every element."""
    return array("d", values.tolist())


def _take_over(request: Any, response: Any) -> Any:
    return request


def answer_later(service: Any, handle: Callable[[Any, Callable[[Any], None]], None]) -> None:
    """Let ``handle(request, reply)`` answer the requests of ``service`` whenever it calls ``reply(response)``.

    The service must have been made with :func:`_take_over` for a callback, so that what comes to be sent is the
    request itself, with the header that rclpy keeps from callbacks. A coroutine that waits for a Future would do as
    well, but the executor then looks at it all the time, which slows the ring down.
    """
    send = service.send_response
    service.send_response = lambda request, header: handle(request, lambda response: send(response, header))


def main() -> None:
    """Run the node."""
    run_node(VesselSimNode)


if __name__ == "__main__":
    main()
