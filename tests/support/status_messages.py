"""Messages of a graph under way, for the screen of `dp status`."""

from __future__ import annotations

import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import (
    AllocationStatus,
    ControllerStatus,
    ObserverState,
    ThrusterCommand,
    ThrusterFeedback,
    Ventilation,
)
from geometry_msgs.msg import Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import Health, from_nanoseconds, health_with, raised
from dp_node.health import to_status
from dp_tools.status.state import StatusState
from marine_model import load_vessel
from marine_model.frames import heading_to_quaternion

VESSEL = load_vessel("cybership3")
NAMES = list(VESSEL.thruster_names)
GRAPH = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers", "vessel_sim")


def stamped(message: Any, seconds: float) -> Any:
    message.header.stamp = from_nanoseconds(round(seconds * 1e9))
    return message


def odometry(
    seconds: float, north: float = 0.13, east: float = -0.08, heading: float = 0.35, valid: bool = True
) -> Odometry:
    message = Odometry()
    message.pose.pose.position.x, message.pose.pose.position.y = north, east
    q = message.pose.pose.orientation
    q.x, q.y, q.z, q.w = heading_to_quaternion(heading)
    if not valid:
        message.pose.covariance[0] = -1.0
    message.twist.twist.linear.x, message.twist.twist.linear.y = 0.021, -0.004
    message.twist.twist.angular.z = 0.01
    return stamped(message, seconds)


def controller_status(seconds: float) -> ControllerStatus:
    message = ControllerStatus(mode="setpoint", status="nominal", message="accepted: set point")
    message.reference_position, message.error = [0.2, -0.2, 0.3], [-0.03, -0.13, -0.05]
    return stamped(message, seconds)


def allocation_status(seconds: float, margin: float = 1.7, turned: float = 2.4, **fields: Any) -> AllocationStatus:
    message = AllocationStatus(status="optimal", azimuth_mode="rotating", margin=margin, margin_turned=turned)
    message.minimum_gain, message.gain_limit = 0.42, math.nan
    message.minimum_gain_both_ways = 0.77
    message.demanded_power, message.commanded_power = 3.1, 2.9
    message.slack = [0.001, -0.002, 0.0]
    message.thrust_saturated = [True, False, False, False]
    message.power_stage = "within"
    for name, value in fields.items():
        setattr(message, name, value)
    return stamped(message, seconds)


def diagnostics(seconds: float, name: str, health: Health) -> DiagnosticArray:
    return stamped(DiagnosticArray(status=[to_status(name, health)]), seconds)


def healthy(**values: object) -> Health:
    return health_with([], {"state": "active", **values})


def under_way(now: float = 1000.0, namespace: str = "/") -> StatusState:
    """Ten seconds of a graph: two alarms of the drivers and the allocator, one that is over, a recording."""
    state = StatusState(namespace, VESSEL)
    space = namespace.strip("/") + "/" if namespace != "/" else ""

    def report(seconds: float, name: str, health: Health) -> None:
        state.update("/diagnostics", diagnostics(seconds, space + name, health), seconds)

    for k in range(11):
        t = now - 10.0 + k
        for name in GRAPH:
            air = [raised("DRIVERS-VENTILATION", "azimuth_port")] if k >= 5 and name == "thruster_drivers" else []
            report(t, name, health_with(air, {"state": "active"}))
        state.update("odometry", odometry(100.0 + 2.0 * k), t)
        for topic in ("odometry", "controller_status", "thruster_command", "pose"):
            state.count(topic, 10 * k, t)
        state.count("actuator_setpoint", 110 * k, t)
    state.update("controller_status", controller_status(120.0), now)
    state.update("observer_state", stamped(ObserverState(valid=True, status="nominal"), 120.0), now)
    demand = WrenchStamped()
    demand.wrench.force.x, demand.wrench.force.y, demand.wrench.torque.z = 4.2, -1.1, 0.3
    state.update("tau_desired", stamped(demand, 120.0), now)
    state.update("allocation_status", allocation_status(120.0), now)
    command = ThrusterCommand(name=NAMES, thrust=[0.58, -2.1, 6.5, 5.0], azimuth=[1.5708, -2.5, 0.2, 0.3])
    state.update("thruster_command", stamped(command, 120.0), now)
    feedback = ThrusterFeedback(name=NAMES, shaft_speed=[9.0, -12.1, 18.0, 16.3], power=[0.1, 0.5, 1.4, 1.1])
    feedback.torque = feedback.azimuth_rate = feedback.pitch_ratio = [0.0] * 4
    feedback.azimuth = [1.5708, -2.4, 0.21, 0.3]
    state.update("thruster_feedback", stamped(feedback, 120.0), now)
    air = Ventilation(name=NAMES, ventilating=[False, False, True, False], beta_q=[1.0] * 4, beta_q2=[1.0] * 4)
    state.update("ventilation", stamped(air, 120.0), now)
    wind = Vector3Stamped()
    wind.vector.x, wind.vector.y = -4.0, -1.0
    state.update("wind", stamped(wind, 120.0), now)
    lost = raised("ALLOCATOR-THRUSTERS-DISABLED", "azimuth_starboard")
    report(now, "thrust_allocator", health_with([lost], {"state": "active", "disabled": "azimuth_starboard"}))
    late = raised("OBSERVER-MEASUREMENTS-LOST", "1 late, beside 5 poses")
    state.alarms.report("dp_observer", {late.kind.code: late.text}, now - 8.0)
    state.alarms.report("dp_observer", {}, now - 7.0)
    report(now, "recorder", health_with([], {"messages": 12345, "bytes": 4_321_000, "lost": 0}, "recording"))
    return state
