"""The allocator as a ROS 2 node: demands in, thruster commands and what they achieve out."""

from __future__ import annotations

import math
from array import array
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from dp_msgs.msg import AllocationStatus, ThrusterCommand, ThrusterFeedback
from geometry_msgs.msg import WrenchStamped

from dp_node import Health, Level, RingNode, StampSequence, run_node, to_nanoseconds
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME
from marine_model.guards import finite_vector
from thrust_allocator.allocator import Allocator
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings, check_settings

_MEANING = {
    Status.OPTIMAL: Level.OK,
    Status.DEMAND_NOT_FINITE: Level.WARN,
    Status.NO_THRUSTER: Level.ERROR,
    Status.HOLD: Level.ERROR,
}
_INITIAL = ("vessel", "feedback")
# Measurements of power that are kept until a demand comes.
_POWERS = 256


@dataclass
class _Tally:
    """What the node has done since it was activated, and since the last report (solve times)."""

    status: Status = Status.OPTIMAL
    message: str = ""
    demands: int = 0
    reported: int = 0
    steps: dict[Status, int] = field(default_factory=lambda: dict.fromkeys(Status, 0))
    solve_time: float = 0.0
    longest: float = 0.0

    def add(self, result: AllocationResult) -> None:
        self.status, self.message = result.status, result.message
        self.demands += 1
        self.steps[result.status] += 1
        self.solve_time += result.solve_time
        self.longest = max(self.longest, result.solve_time)


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

    def started(self) -> None:
        """Begin anew: without thrust, pointing where the last command left the thrusters."""
        self._core.reset(azimuth=self._azimuth)
        self._forget()

    def health(self) -> Health:
        """Return status of the last step, counts of fall-backs, and solve times."""
        tally = self._tally
        fresh = tally.demands - tally.reported
        values: dict[str, object] = {
            "status": tally.status.value,
            "detail": tally.message,
            "demands": tally.demands,
            **{f"steps_{status.value}": count for status, count in tally.steps.items()},
            "solver": self.settings.solver,
            "solve_time_mean_us": 1e6 * tally.solve_time / fresh if fresh else 0.0,
            "solve_time_max_us": 1e6 * tally.longest,
        }
        tally.reported = tally.demands
        tally.solve_time = tally.longest = 0.0
        if self._waiting:
            return Health(Level.WARN, "no thruster_feedback yet: demands are refused", values)
        if not fresh:
            return Health(Level.WARN, "no tau_desired: no thruster_command", values)
        level = _MEANING[tally.status]
        return Health(level, "nominal" if level is Level.OK else f"{tally.status}: {tally.message}", values)

    def _needs_power(self) -> bool:
        power = self.settings.power
        return power.limit != "none" and power.measured

    def _hear_feedback(self) -> None:
        """Listen to thruster_feedback where it is needed; it comes ten times as often as demands do."""
        if not self._hears_feedback and (self._initial == "feedback" or self._needs_power()):
            self._hears_feedback = True
            self.listen(ThrusterFeedback, "thruster_feedback", self._on_feedback)

    def _forget(self) -> None:
        self._powers: deque[tuple[int, float]] = deque(maxlen=_POWERS)
        self._held: Any = None
        self._stamps = StampSequence("tau_desired")
        self._waiting = self._initial == "feedback"
        self._tally = _Tally()

    def _on_feedback(self, message: Any) -> None:
        if self._needs_power():
            self._powers.append((to_nanoseconds(message.header.stamp), self._total_power(message)))
            if self._held is not None and self._powers[-1][0] >= self._needed(self._held):
                held, self._held = self._held, None
                self._on_demand(held)
        if self._waiting:
            self._start_from(message)

    def _total_power(self, message: Any) -> float:
        """Return the measured power of the thrusters that are not lost, W."""
        enabled = dict(zip(self._names, self.settings.thruster_enabled or (True,) * len(self._names), strict=True))
        power: list[float] = finite_vector("thruster_feedback: power", message.power, len(self._names)).tolist()
        return sum([value for name, value in zip(message.name, power, strict=True) if enabled.get(name, False)], 0.0)

    def _needed(self, demand: Any) -> int:
        """Return the stamp of the feedback before a demand, where the simulator sends one at every time step."""
        return to_nanoseconds(demand.header.stamp) - round(self.vessel.simulation.time_step * 1e9)

    def _start_from(self, message: Any) -> None:
        names = list(message.name)
        if sorted(names) != sorted(self._names):
            raise InputError(f"thruster_feedback: expected the thrusters {self._names}, found {names}")
        order = [names.index(name) for name in self._names]
        n = len(order)
        azimuth = finite_vector("thruster_feedback: azimuth", message.azimuth, n)[order]
        shaft_speed = finite_vector("thruster_feedback: shaft_speed", message.shaft_speed, n)[order]
        self._core.reset(self.vessel.propellers.thrust(shaft_speed), azimuth)
        self._waiting = False

    def _on_demand(self, message: Any) -> None:
        if message.header.frame_id not in ("", BODY_FRAME):
            raise InputError(f"tau_desired: expected frame_id '{BODY_FRAME}', found '{message.header.frame_id}'")
        if self._needs_power():
            stamp = to_nanoseconds(message.header.stamp)
            # In lockstep the measured power is the same in every run, so that the demand waits for it.
            if self.synchronous and self._powers and self._powers[-1][0] < self._needed(message):
                self._held = message
                return
            powers = [power for at, power in self._powers if at < stamp]
            if powers:
                self._core.measure_power(powers[-1])
        if self._waiting:
            raise InputError("tau_desired: refused until the first thruster_feedback says where the thrusters point")
        dt = self._stamps.step(message.header.stamp, self.vessel.measurement.sample_time)
        wrench = message.wrench
        result = self._core.step((wrench.force.x, wrench.force.y, wrench.torque.z), dt)
        self._publish(message.header.stamp, result)
        self._azimuth = result.azimuth
        changed = result.status is not self._tally.status
        self._tally.add(result)
        if changed:
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
