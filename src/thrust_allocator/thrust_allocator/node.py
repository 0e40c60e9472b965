"""The allocator as a ROS 2 node: demands in, thruster commands and what they achieve out."""

from __future__ import annotations

import math
from array import array
from collections import deque
from typing import Any

import numpy as np
from dp_msgs.msg import AllocationStatus, ThrusterCommand, ThrusterFeedback
from geometry_msgs.msg import WrenchStamped

from dp_node import Health, RingNode, StampSequence, run_node, to_nanoseconds
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME
from marine_model.guards import FloatArray, finite_vector
from thrust_allocator.allocator import Allocator
from thrust_allocator.node_health import Tally, health_of
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings, check_settings

_INITIAL = ("vessel", "feedback")
# Measurements of power that are kept until a demand comes.
_POWERS = 256


class AllocatorNode(RingNode[AllocatorSettings]):
    """Answers every tau_desired with a thruster_command, tau_achieved and allocation_status of the same stamp."""

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
        rehearsal = Allocator(self.vessel, self.settings).step(np.zeros(3), self.vessel.measurement.sample_time)
        self._status_message(AllocationStatus().header, rehearsal)
        self._names = list(self.vessel.thruster_names)
        self._azimuth: Any = None
        self._command = self.publish_on(ThrusterCommand, "thruster_command")
        self._achieved = self.publish_on(WrenchStamped, "tau_achieved")
        self._status = self.publish_on(AllocationStatus, "allocation_status")
        self._forget()
        self.listen(WrenchStamped, "tau_desired", self._on_demand)
        self._hears_feedback = False
        self._hear_feedback()

    def apply(self, settings: AllocatorSettings) -> None:
        """Hand changed settings to the core; they hold from the next demand on."""
        self._core.apply(settings)
        self._hear_feedback()
        if self._held is not None and not self.settings.power.needs_measurement:
            self._answer_held()

    def started(self) -> None:
        """Begin anew: without thrust, pointing where the last command left the thrusters."""
        self._core.reset(azimuth=self._azimuth)
        self._forget()

    def health(self) -> Health:
        """Return status of the last answer, counts of fall-backs, what limits it, and solve times."""
        waiting = ""
        if self._waiting:
            waiting = "no thruster_feedback yet: demands are refused"
        elif self._held is not None:
            waiting = "tau_desired waits for the power of thruster_feedback"
        health = health_of(self._tally, self.settings, self.vessel, waiting)
        self._tally.reported()
        return health

    def _hear_feedback(self) -> None:
        """Listen to thruster_feedback where it is needed; it comes ten times as often as demands do."""
        if not self._hears_feedback and (self._initial == "feedback" or self.settings.power.needs_measurement):
            self._hears_feedback = True
            self.listen(ThrusterFeedback, "thruster_feedback", self._on_feedback)

    def _forget(self) -> None:
        # Stamp and power of every thruster; None where it was refused.
        self._powers: deque[tuple[int, FloatArray | None]] = deque(maxlen=_POWERS)
        self._held: Any = None
        self._stamps = StampSequence("tau_desired")
        self._waiting = self._initial == "feedback"
        self._tally = Tally()

    def _on_feedback(self, message: Any) -> None:
        if self.settings.power.needs_measurement:
            self._powers.append((to_nanoseconds(message.header.stamp), None))
            try:
                power = finite_vector("thruster_feedback: power", message.power, len(self._names))
                self._powers[-1] = (self._powers[-1][0], power[self._order(message)])
            finally:
                # Refused or not: a demand that waits is answered, or the ring would stand still.
                if self._held is not None and self._powers[-1][0] >= self._needed(self._held):
                    self._answer_held()
        if self._waiting:
            self._start_from(message)

    def _answer_held(self) -> None:
        held, self._held = self._held, None
        try:
            self._answer(held)
        except InputError as error:
            self.refuse(str(error))

    def _order(self, message: Any) -> list[int]:
        """Return where each thruster of the vessel stands in a feedback."""
        names = list(message.name)
        if sorted(names) != sorted(self._names):
            raise InputError(f"thruster_feedback: expected the thrusters {self._names}, found {names}")
        return [names.index(name) for name in self._names]

    def _measure_power(self, stamp: int) -> None:
        """Hand the core what was measured last before ``stamp`` (ns), of the thrusters that are not lost."""
        for at, power in reversed(self._powers):
            if at < stamp:
                if power is not None:
                    self._core.measure_power(float(power[self.settings.enabled(self.vessel)].sum()))
                return

    def _needed(self, demand: Any) -> int:
        """Return the stamp of the feedback before a demand, where the simulator sends one at every time step."""
        return to_nanoseconds(demand.header.stamp) - round(self.vessel.simulation.time_step * 1e9)

    def _start_from(self, message: Any) -> None:
        order = self._order(message)
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
        # In lockstep the measured power is the same in every run, so that a demand waits for it. Before the first
        # demand there has been none.
        if self.synchronous and self.settings.power.needs_measurement and self._stamps.last is not None:
            latest = self._powers[-1][0] if self._powers else None
            if latest is None or latest < self._needed(message):
                if self._held is not None:
                    self.refuse("tau_desired: another came before the thruster_feedback that this one waited for")
                self._held = message
                return
        self._answer(message)

    def _answer(self, message: Any) -> None:
        stamp = message.header.stamp
        dt = self._stamps.step(stamp, self.vessel.measurement.sample_time)
        if self.settings.power.needs_measurement:
            self._measure_power(to_nanoseconds(stamp))
        wrench = message.wrench
        result = self._core.step((wrench.force.x, wrench.force.y, wrench.torque.z), dt)
        self._publish(stamp, result)
        self._azimuth = result.azimuth
        before = Status.OPTIMAL if self._tally.last is None else self._tally.last.status
        self._tally.add(result, self.settings.solver)
        if result.status is not before:
            self._report(result)

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

    def _publish(self, stamp: Any, result: AllocationResult) -> None:
        command = ThrusterCommand()
        command.header.stamp = stamp
        command.header.frame_id = BODY_FRAME
        command.name = self._names
        command.thrust = array("d", result.thrust.tobytes())
        command.azimuth = array("d", result.azimuth.tobytes())
        self._command.publish(command)

        achieved = WrenchStamped()
        achieved.header = command.header
        surge, sway, yaw = result.tau_achieved.tolist()
        achieved.wrench.force.x = surge
        achieved.wrench.force.y = sway
        achieved.wrench.torque.z = yaw
        self._achieved.publish(achieved)

        self._status.publish(self._status_message(command.header, result))

    def _status_message(self, header: Any, result: AllocationResult) -> AllocationStatus:
        status = AllocationStatus()
        status.header = header
        status.status = result.status.value
        status.azimuth_mode = result.azimuth_mode
        status.solver = result.solver
        status.cost = result.cost
        status.slack = result.slack
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
        margin = result.margin
        status.margin, status.margin_turned = margin.fixed, margin.turning
        gains = result.gains
        status.minimum_gain = gains.global_gain
        status.minimum_gain_local = gains.local_gain
        status.minimum_gain_horizon = gains.horizon_gain
        status.minimum_gain_both_ways = result.gain_both_ways.gain
        status.weakest_direction = gains.direction
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


def main() -> None:
    """Run the node until SIGINT or SIGTERM."""
    run_node(AllocatorNode)
