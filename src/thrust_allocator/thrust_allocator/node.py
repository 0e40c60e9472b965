"""The allocator as a ROS 2 node: demands in, thruster commands and what they achieve out."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from dp_msgs.msg import AllocationStatus, ThrusterCommand, ThrusterFeedback, Ventilation
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import Health, Inbox, RingNode, StampSequence, WaitingRoom, run_node, seconds_between, to_nanoseconds
from marine_model import Vessel
from marine_model.axes import in_six
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME
from marine_model.guards import FloatArray, finite_number, finite_vector
from thrust_allocator.allocator import Allocator
from thrust_allocator.feasible.directions import along_direction
from thrust_allocator.methods import knows_speed
from thrust_allocator.node_health import Tally, health_of
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings, check_settings
from thrust_allocator.step import Total

VENTILATION = "ventilation"
ODOMETRY = "odometry"
_INITIAL = ("vessel", "feedback")


class AllocatorNode(RingNode[AllocatorSettings]):
    """Answers every tau_desired with a thruster_command, tau_achieved and allocation_status of the same stamp.

    Deactivated, it goes on answering: thrust is ramped to zero within its rates, azimuths stay, and what is achieved
    meanwhile is told, so that observer and controller know that the force is gone.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("thrust_allocator", **kwargs)
        self._initial: str = self.structural(
            "initial_azimuth",
            "vessel",
            "Where thrusters point at start: the fixed directions of the vessel file, or what the first "
            "thruster_feedback says, until which demands are refused (one of: vessel, feedback)",
        )
        if self._initial not in _INITIAL:
            raise InputError(f"initial_azimuth: expected one of {', '.join(_INITIAL)}, found '{self._initial}'")
        self._resting = False  # deactivated, on the way to zero thrust or there
        # Stamp, thrust and azimuth of the last command: where an activation goes on from.
        self._commanded: tuple[int, FloatArray, FloatArray] | None = None

    def default_settings(self, vessel: Vessel) -> AllocatorSettings:
        """Return settings with one element for every thruster of the vessel."""
        return AllocatorSettings.for_vessel(vessel)

    def check(self, settings: AllocatorSettings) -> None:
        """Refuse settings of the wrong length, and solvers that are not installed."""
        check_settings(settings, self.vessel)

    def build(self) -> None:
        """Make core, publishers and subscriptions."""
        self._core = Allocator(self.vessel, self.settings)
        # What is told of an answer is machine code too, and none of it is to be compiled while a demand waits.
        # A demand along every axis: of none, nothing is looked up.
        some = np.ones(len(self.vessel.degrees_of_freedom))
        rehearsal = Allocator(self.vessel, self.settings).step(some, self.vessel.measurement.sample_time)
        self._status_message(AllocationStatus().header, rehearsal)
        self._names = list(self.vessel.thruster_names)
        self._axes: list[int] = self.vessel.axis_indices.tolist()
        self._resting = False
        self._command = self.publish_on(ThrusterCommand, "thruster_command", when_inactive=True)
        self._achieved = self.publish_on(WrenchStamped, "tau_achieved", when_inactive=True)
        self._status = self.publish_on(AllocationStatus, "allocation_status", when_inactive=True)
        # Power of every thruster; where it points; its beta_Q2.
        self._power: Inbox[FloatArray] = Inbox("the power of thruster_feedback")
        self._direction: Inbox[FloatArray] = Inbox("the directions of thruster_feedback")
        self._ventilation: Inbox[FloatArray] = Inbox(VENTILATION)
        # Speed ahead, shape (1,).
        self._speed: Inbox[FloatArray] = Inbox(ODOMETRY)
        self._time_step = round(self.vessel.simulation.time_step * 1e9)
        self._room: WaitingRoom[Any] = WaitingRoom(self._time_step)
        self._holds_first = False
        self._forget()
        self.listen(WrenchStamped, "tau_desired", self._on_demand, exclusive=True)
        self._hears_feedback = self._hears_ventilation = self._hears_odometry = False
        self._hear()

    def apply(self, settings: AllocatorSettings) -> None:
        """Hand changed settings to the core; they hold from the next demand on."""
        if not self._resting:
            self._core.apply(settings)
        self._hear()
        self._answer_held()

    def started(self) -> None:
        """Begin anew, from where the last command left the thrusters."""
        if self._resting:
            self._resting = False
            self._core.apply(self.settings)
        if self._commanded is None:
            self._core.reset()
        else:
            self._core.reset(*self._commanded[1:])
        self._forget()

    def stopped(self) -> None:
        """Ask no thrust of any thruster from now on."""
        self._resting = True
        self._core.apply(self.settings.model_copy(update={"thruster_enabled": (False,) * len(self._names)}))

    @property
    def acts(self) -> bool:
        """Also while inactive after a deactivation, until thrust is at zero and from then on to say so."""
        return self.active or (self._resting and self._built)

    def health(self) -> Health:
        """Return status of the last answer, counts of fall-backs, what limits it, and solve times."""
        waiting, missing = "", self._room.waits_for(self._needed(self._holds_first))
        if missing:
            waiting = " and ".join(missing)
            if VENTILATION in missing and not self.count_publishers(VENTILATION):
                waiting += ", which nobody publishes"
        health = health_of(self._tally, self.settings, self.vessel, waiting, self._waiting)
        self._tally.reported()
        return health

    def _hear(self) -> None:
        """Listen to what is needed only where it is: it comes ten times as often as demands do."""
        settings = self.settings
        if not self._hears_feedback and (
            self._initial == "feedback" or settings.power.needs_measurement or settings.needs_direction
        ):
            self._hears_feedback = True
            self.listen(ThrusterFeedback, "thruster_feedback", self._on_feedback)
        if not self._hears_ventilation and self.settings.antispin.enabled:
            self._hears_ventilation = True
            self.listen(Ventilation, VENTILATION, self._on_ventilation)
        # From the start where it may ever be asked for: a demand that waits for it may come after it.
        if not self._hears_odometry and (settings.needs_speed or knows_speed(self.vessel)):
            self._hears_odometry = True
            self.listen(Odometry, ODOMETRY, self._on_odometry)

    def _needed(self, is_first: bool) -> list[Inbox[FloatArray]]:
        """Return the inboxes that have a say in the next demand; before the first one nothing but odometry has come."""
        needed = [self._speed] if self.settings.needs_speed else []
        if is_first:
            return needed
        if self.settings.power.needs_measurement:
            needed.append(self._power)
        if self.settings.needs_direction:
            needed.append(self._direction)
        if self.settings.antispin.enabled:
            needed.append(self._ventilation)
        return needed

    def _forget(self) -> None:
        self._power.clear()
        self._direction.clear()
        self._ventilation.clear()
        self._speed.clear()
        self._room.clear()
        self._holds_first = False
        self._stamps = StampSequence("tau_desired", self.vessel.measurement.sample_time)
        self._waiting = self._initial == "feedback" and self._commanded is None
        self._tally = Tally()

    def _on_feedback(self, message: Any) -> None:
        self._keep(
            self._power,
            message,
            lambda: finite_vector("thruster_feedback: power", message.power, len(self._names))[
                self._order("thruster_feedback", message)
            ],
            needed=self.settings.power.needs_measurement,
        )
        self._keep(
            self._direction,
            message,
            lambda: finite_vector("thruster_feedback: azimuth", message.azimuth, len(self._names))[
                self._order("thruster_feedback", message)
            ],
            needed=self.settings.needs_direction,
        )
        if self._waiting:
            self._start_from(message)

    def _on_ventilation(self, message: Any) -> None:
        self._keep(self._ventilation, message, lambda: self._torque_loss(message), self.settings.antispin.enabled)

    def _on_odometry(self, message: Any) -> None:
        # That of a sample comes before its demand: it counts as of one time step before, like all that is waited for.
        self._keep(
            self._speed,
            message,
            lambda: _speed_ahead(message),
            self.settings.needs_speed,
            lead=self._time_step,
        )

    def _torque_loss(self, message: Any) -> FloatArray:
        """Return beta_Q2 in the order of the vessel file."""
        loss = finite_vector("ventilation: beta_q2", message.beta_q2, len(self._names))
        if not ((loss >= 0.0) & (loss <= 1.0)).all():
            raise InputError(f"ventilation: beta_q2: expected factors from 0 to 1, found {loss.tolist()}")
        return loss[self._order(VENTILATION, message)]

    def _keep(
        self, inbox: Inbox[FloatArray], message: Any, read: Callable[[], FloatArray | None], needed: bool, lead: int = 0
    ) -> None:
        """Put what ``read`` returns into ``inbox``, and answer the demand that waited for it.

        What is not ``needed`` now is kept too: once switched on, a demand waits for what came a time step before it,
        which may have come before the switch. ``lead`` (ns) is taken off its stamp.
        """
        found = None
        try:
            found = read()
        except InputError:
            if needed:
                raise
        finally:
            # Refused or not: a demand that waits is answered, or the ring would stand still.
            inbox.put(to_nanoseconds(message.header.stamp) - lead, found)
            self._answer_held()

    def _answer_held(self) -> None:
        held = self._room.release(self._needed(self._holds_first))
        if held is None:
            return
        try:
            self._answer(*held)
        except InputError as error:
            self.refuse(str(error))

    def _order(self, topic: str, message: Any) -> list[int]:
        """Return where each thruster of the vessel stands in a message."""
        names = list(message.name)
        if sorted(names) != sorted(self._names):
            raise InputError(f"{topic}: expected the thrusters {self._names}, found {names}")
        return [names.index(name) for name in self._names]

    def _measure(self, stamp: int) -> None:
        """Hand the core what came last before ``stamp`` (ns): power of the thrusters that are not lost, ventilation."""
        if self.settings.power.needs_measurement:
            power = self._power.take(stamp)
            if power is not None:
                self._core.measure_power(float(power[1][self.settings.enabled(self.vessel)].sum()))
        if self.settings.needs_direction:
            direction = self._direction.take(stamp)
            if direction is not None:
                self._core.measure_azimuth(direction[1])
        if self.settings.antispin.enabled:
            loss = self._ventilation.take(stamp)
            if loss is not None:
                self._core.measure_ventilation(loss[1], seconds_between(loss[0], stamp))
        if self.settings.needs_speed:
            speed = self._speed.take(stamp)
            if speed is not None:
                self._core.measure_speed(float(speed[1][0]))

    def _start_from(self, message: Any) -> None:
        order = self._order("thruster_feedback", message)
        n = len(order)
        azimuth = finite_vector("thruster_feedback: azimuth", message.azimuth, n)[order]
        shaft_speed = finite_vector("thruster_feedback: shaft_speed", message.shaft_speed, n)[order]
        self._core.reset(self.vessel.propellers.thrust(shaft_speed), azimuth)
        self._waiting = False

    def _on_demand(self, message: Any) -> None:
        if message.header.frame_id not in ("", BODY_FRAME):
            raise InputError(f"tau_desired: expected frame_id '{BODY_FRAME}', found '{message.header.frame_id}'")
        if self._waiting:
            raise InputError("tau_desired: refused until the first thruster_feedback says where the thrusters point")
        # In lockstep what was measured is the same in every run, so that a demand waits for it.
        is_first, stamp = self._stamps.last is None, to_nanoseconds(message.header.stamp)
        dt = self._stamps.step(message.header.stamp, self._since_last_command(stamp))
        if self.synchronous:
            missing = self._room.missing(stamp, self._needed(is_first))
            if missing:
                if self._room.holds:
                    self.refuse(f"tau_desired: another came before {' and '.join(missing)} that this one waited for")
                self._room.hold(stamp, (message, dt))
                self._holds_first = is_first
                return
        self._answer(message, dt)

    def _answer(self, message: Any, dt: float) -> None:
        stamp = message.header.stamp
        if dt > self.vessel.drivers.command_timeout:
            # Since then the drivers have ramped thrust to zero; it comes back from there.
            self._core.fade(dt - self.vessel.drivers.command_timeout)
        self._measure(to_nanoseconds(stamp))
        force, torque = message.wrench.force, message.wrench.torque
        six = (force.x, force.y, force.z, torque.x, torque.y, torque.z)
        result = self._core.step([six[i] for i in self._axes], dt)
        wrench = result.wrench
        if self._resting:
            if result.status is Status.DEMAND_NOT_FINITE:
                self.refuse(result.message)
            result, wrench = self._as_resting(result)
        self._publish(stamp, result, wrench)
        self._commanded = to_nanoseconds(stamp), result.thrust, result.azimuth
        before = Status.OPTIMAL if self._tally.last is None else self._tally.last.status
        self._tally.add(result, self.settings.solver, dt)
        if result.status is not before:
            self._report(result)

    def _as_resting(self, result: AllocationResult) -> tuple[AllocationResult, FloatArray]:
        """Return an answer and its wrench in which what is left of the thrusts counts: a lost thruster's would not."""
        vessel, totals = self.vessel, result.totals.copy()
        wrench = result.thrust @ along_direction(vessel.columns6, result.azimuth)
        totals[: Total.COST] = wrench[self._axes]
        if not vessel.is_submerged:
            wrench = in_six(vessel.degrees_of_freedom, totals[: Total.COST])
        return replace(result, totals=totals, status=Status.DEACTIVATED, message="thrust is ramped to zero"), wrench

    def _since_last_command(self, stamp: int) -> float:
        """Return the time from the last command of an earlier activation to ``stamp`` (ns), s; one sample without."""
        if self._commanded is None or stamp <= self._commanded[0]:
            return self.vessel.measurement.sample_time
        return seconds_between(self._commanded[0], stamp)

    def _report(self, result: AllocationResult) -> None:
        if result.status is Status.OPTIMAL:
            self.get_logger().info("optimal again")
        elif result.problem is None:
            self.get_logger().warning(f"{result.status}: {result.message}")
        else:
            # Enough to build the problem again.
            problem = result.problem
            self.get_logger().error(
                f"{result.status}: {result.message}; tau {problem.tau.tolist()}, B {problem.B.tolist()}, "
                f"A {problem.A.tolist()}, b_lower {problem.b_lower.tolist()}, b_upper {problem.b_upper.tolist()}"
            )

    def _publish(self, stamp: Any, result: AllocationResult, wrench: FloatArray) -> None:
        command = ThrusterCommand()
        command.header.stamp = stamp
        command.header.frame_id = BODY_FRAME
        command.name = self._names
        command.thrust = array("d", result.thrust.tobytes())
        command.azimuth = array("d", result.azimuth.tobytes())
        self._command.publish(command)

        achieved = WrenchStamped()
        achieved.header = command.header
        force, torque = achieved.wrench.force, achieved.wrench.torque
        force.x, force.y, force.z, torque.x, torque.y, torque.z = wrench.tolist()
        self._achieved.publish(achieved)

        self._status.publish(self._status_message(command.header, result))

    def _status_message(self, header: Any, result: AllocationResult) -> AllocationStatus:
        status = AllocationStatus()
        status.header = header
        status.status = result.status.value
        status.azimuth_mode = result.azimuth_mode
        status.performance_measure = result.mean_force
        status.solver = result.solver
        status.cost = result.cost
        status.slack = array("d", result.slack.tobytes())
        status.method, status.detail = result.method, result.detail
        status.feasible_load = result.feasible_load
        if result.method_report is not None:
            status.tau_feasible = array("d", result.tau_feasible.tobytes())
            if np.isfinite(result.tau_qp).all():
                status.tau_qp = array("d", result.tau_qp.tobytes())
        status.demanded_power = result.demanded_power
        status.commanded_power = result.commanded_power
        status.rotating = list(result.rotating)
        status.thrust_saturated = list(result.thrust_saturated)
        status.azimuth_saturated = list(result.azimuth_saturated)
        if result.power is not None:
            status.power_stage = result.power.stage.name.lower()
            status.bus_power = array("d", result.power.bus.tobytes())
            status.bus_limited = list(result.power.bus_limited)
        if result.sectors is not None:
            status.sub_problem = result.sectors.sub_problem
            status.crossing = list(result.sectors.crossing)
        status.antispin = result.antispin
        status.torque_loss = array("d", result.torque_loss.tobytes())
        margin = result.margin
        status.margin, status.margin_turned = margin.fixed, margin.turning
        gains = result.gains
        status.minimum_gain = gains.global_gain
        status.minimum_gain_local = gains.local_gain
        status.minimum_gain_horizon = gains.horizon_gain
        status.minimum_gain_both_ways = result.gain_both_ways.gain
        status.weakest_direction = array("d", np.ascontiguousarray(gains.direction).tobytes())
        status.weakest_azimuth, status.weakest_length = gains.projection_angle, gains.projection_length
        avoidance = result.avoidance
        if avoidance is None:
            status.singularity_method = "none"
            status.gain_limit = status.minimum_gain_free = status.cost_free = math.nan
        else:
            status.singularity_method = avoidance.method
            status.gain_limit = avoidance.threshold
            status.minimum_gain_free = avoidance.minimum_gain_free
            status.cost_free = avoidance.cost_free
            status.waiting = avoidance.waiting
            status.locked = avoidance.locked
            status.released = avoidance.released
            status.gain_crossing = avoidance.crossing
        return status


def _speed_ahead(message: Any) -> FloatArray | None:
    """Return the surge speed of a nav_msgs/Odometry, shape (1,), m/s; None of an estimate that is not valid."""
    if message.child_frame_id != BODY_FRAME:
        raise InputError(f"odometry child_frame_id: expected frame '{BODY_FRAME}', found '{message.child_frame_id}'")
    # An invalid observer says so with a negative variance; its numbers are not looked at.
    if message.pose.covariance[0] < 0.0:
        return None
    return np.array([finite_number("odometry twist.linear.x", message.twist.twist.linear.x)])


def main() -> None:
    """Run the node until SIGINT or SIGTERM."""
    run_node(AllocatorNode)
