"""Every node under arbitrary inputs: none ends it, none passes quietly, and nothing not finite comes out.

DP_FUZZ_CASES says how many cases a node gets at least (one case: one message, change of parameters or transition).
"""

from __future__ import annotations

import os
from array import array
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import ActuatorSetpoint, ThrusterCommand, ThrusterFeedback, Ventilation
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry, Path

from dp_controller.node import ControllerNode
from dp_observer.node import ObserverNode
from marine_model import load_vessel
from marine_model.frames import BODY_FRAME, MAP_FRAME
from support.node_bench import node_bench
from support.node_fuzz import Input, Target, fuzz, stamped
from thrust_allocator.node import AllocatorNode
from thruster_drivers.drivers import SENSOR_LOST
from thruster_drivers.node import DriversNode
from vessel_sim.node import VesselSimNode

pytestmark = pytest.mark.usefixtures("ros_domain_id")

CASES = int(os.environ.get("DP_FUZZ_CASES", "500"))
NAMES = list(load_vessel("cybership3").thruster_names)
N = len(NAMES)
WRENCH = ("wrench.force.x", "wrench.force.y", "wrench.torque.z")
POSE = tuple(
    f"pose.{name}"
    for name in ("position.x", "position.y", "orientation.x", "orientation.y", "orientation.z", "orientation.w")
)


def doubles(value: float = 0.0) -> array[float]:
    return array("d", [value] * N)


def _pose(stamp: int) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.header.frame_id = MAP_FRAME
    message.pose.pose.orientation.w = 1.0
    return stamped(message, stamp)


def _wrench(stamp: int) -> WrenchStamped:
    message = WrenchStamped()
    message.header.frame_id = BODY_FRAME
    message.wrench.force.x = 1.0
    return stamped(message, stamp)


def _odometry(stamp: int) -> Odometry:
    message = Odometry(child_frame_id=BODY_FRAME)
    message.header.frame_id = MAP_FRAME
    message.pose.pose.orientation.w = 1.0
    return stamped(message, stamp)


def _setpoint(stamp: int) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = MAP_FRAME
    message.pose.orientation.w = 1.0
    return stamped(message, stamp)


def _path(stamp: int) -> Path:
    message = Path(poses=[_setpoint(stamp + 10**9), _setpoint(stamp + 2 * 10**9)])
    message.header.frame_id = MAP_FRAME
    return stamped(message, stamp)


def _wind(stamp: int) -> Vector3Stamped:
    message = Vector3Stamped()
    message.header.frame_id = BODY_FRAME
    return stamped(message, stamp)


def _feedback(stamp: int) -> ThrusterFeedback:
    numbers = {name: doubles() for name in ("shaft_speed", "torque", "power", "azimuth", "azimuth_rate", "pitch_ratio")}
    return stamped(ThrusterFeedback(name=NAMES, **numbers), stamp)


def _command(stamp: int) -> ThrusterCommand:
    return stamped(ThrusterCommand(name=NAMES, thrust=doubles(0.5), azimuth=doubles()), stamp)


def _ventilation(stamp: int) -> Ventilation:
    return stamped(Ventilation(name=NAMES, ventilating=[False] * N, beta_q=doubles(1.0), beta_q2=doubles(1.0)), stamp)


def _setpoints(stamp: int) -> ActuatorSetpoint:
    message = ActuatorSetpoint(name=NAMES, torque=doubles(0.01), azimuth_rate=doubles(), pitch_ratio=array("d"))
    return stamped(message, stamp)


def _no_fix(message: Any) -> bool:
    return bool(message.pose.covariance[0] < 0.0)


TARGETS: dict[Any, Target] = {
    ObserverNode: Target(
        (
            Input("pose", _pose, tuple(f"pose.{name}" for name in POSE), _no_fix),
            Input("tau_achieved", _wrench, WRENCH),
        ),
        timers=("_watch",),
    ),
    ControllerNode: Target(
        (
            Input(
                "odometry",
                _odometry,
                (
                    *(f"pose.{name}" for name in POSE),
                    "twist.twist.linear.x",
                    "twist.twist.linear.y",
                    "twist.twist.angular.z",
                ),
                _no_fix,
            ),
            Input("tau_achieved", _wrench, WRENCH),
            Input("setpoint", _setpoint, POSE),
            Input("joystick", _wrench, WRENCH),
            Input("path", _path),
            Input("wind", _wind, ("vector.x", "vector.y")),
        )
    ),
    AllocatorNode: Target(
        (
            # What is measured is looked at only where it is needed.
            Input("thruster_feedback", _feedback),
            Input("ventilation", _ventilation),
            Input("tau_desired", _wrench, WRENCH),
        ),
        may_be_nan={
            "AllocationStatus": frozenset(
                (
                    "performance_measure",
                    "gain_limit",
                    "feasible_load",
                    "margin",
                    "margin_turned",
                    "minimum_gain",
                    "minimum_gain_local",
                    "minimum_gain_horizon",
                    "minimum_gain_both_ways",
                    "minimum_gain_free",
                    "cost_free",
                    "weakest_direction",
                    "weakest_azimuth",
                    "weakest_length",
                )
            )
        },
        tells=lambda node: str(node._tally.last.status) == "demand_not_finite",
    ),
    DriversNode: Target(
        (
            Input("thruster_feedback", _feedback, ("shaft_speed", "torque", "azimuth")),
            Input("thruster_command", _command, ("thrust", "azimuth")),
        ),
        tells=lambda node: node._tally.status == SENSOR_LOST,
    ),
    VesselSimNode: Target(
        (Input("actuator_setpoint", _setpoints, ("torque", "azimuth_rate", "pitch_ratio")),),
        timers=("_send_pose", "_send_feedback", *["_step"] * 5),
    ),
}


@pytest.mark.timeout(60 + CASES)
@pytest.mark.parametrize("make", TARGETS)
def test_nothing_ends_a_node_nothing_passes_quietly_and_nothing_not_finite_comes_out(make: Any) -> None:
    with np.errstate(all="ignore"), node_bench(make) as bench:
        done = fuzz(bench, TARGETS[make], CASES)
    print(f"{make.__name__}: {done} cases")
    assert done >= CASES // 2
