"""Between the observer's types and ROS messages."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from dp_msgs.msg import ObserverState
from nav_msgs.msg import Odometry

from dp_node import from_nanoseconds
from dp_observer.estimate import ObserverEstimate
from dp_observer.input_checks import checked_place, checked_position, checked_tau, checked_vertical_tau
from marine_model.errors import InputError
from marine_model.frames import (
    BODY_FRAME,
    MAP_FRAME,
    attitude_to_quaternion,
    heading_to_quaternion,
    quaternion_to_attitude,
    quaternion_to_heading,
)
from marine_model.guards import FloatArray


def require_frame(topic: str, expected: str, found: str) -> None:
    """Raise InputError unless a message on ``topic`` is in the frame ``expected``."""
    if found != expected:
        raise InputError(f"{topic}: expected frame_id '{expected}', found '{found}'")


def is_fix(message: Any) -> bool:
    """Return whether a pose message carries a fix: a negative first covariance says that there is none."""
    return not message.pose.covariance[0] < 0.0


def to_position(message: Any) -> FloatArray:
    """Return north (m), east (m), heading (rad), shape (3,), of a PoseWithCovarianceStamped. Raises InputError."""
    pose = message.pose.pose
    q = pose.orientation
    return checked_position([pose.position.x, pose.position.y, quaternion_to_heading(q.x, q.y, q.z, q.w)])


def to_tau(message: Any) -> FloatArray:
    """Return surge (N), sway (N), yaw (N m), shape (3,), of a WrenchStamped. Raises InputError."""
    wrench = message.wrench
    return checked_tau([wrench.force.x, wrench.force.y, wrench.torque.z])


def to_vertical(message: Any) -> FloatArray:
    """Return depth (m), roll, pitch (rad), shape (3,), of a PoseWithCovarianceStamped. Raises InputError."""
    pose = message.pose.pose
    q = pose.orientation
    roll, pitch, _ = quaternion_to_attitude(q.x, q.y, q.z, q.w)
    return checked_place([pose.position.z, roll, pitch])


def to_vertical_tau(message: Any) -> FloatArray:
    """Return heave (N), roll, pitch (N m), shape (3,), of a WrenchStamped. Raises InputError."""
    wrench = message.wrench
    return checked_vertical_tau([wrench.force.z, wrench.torque.x, wrench.torque.y])


def to_odometry(estimate: ObserverEstimate, stamp: int) -> Odometry:
    """Return position in ``map_ned`` and velocity in ``base_link_frd``; covariance[0] is -1 if not valid."""
    message = Odometry(child_frame_id=BODY_FRAME)
    message.header.stamp = from_nanoseconds(stamp)
    message.header.frame_id = MAP_FRAME
    north, east, heading = estimate.position.tolist()
    point, orientation = message.pose.pose.position, message.pose.pose.orientation
    point.x, point.y = north, east
    orientation.x, orientation.y, orientation.z, orientation.w = heading_to_quaternion(heading)
    if not estimate.valid:
        covariance = np.zeros(36)
        covariance[0] = -1.0
        message.pose.covariance = covariance
    twist = message.twist.twist
    twist.linear.x, twist.linear.y, twist.angular.z = estimate.velocity.tolist()
    if estimate.vertical is not None:
        point.z, roll, pitch = estimate.vertical.position.tolist()
        orientation.x, orientation.y, orientation.z, orientation.w = attitude_to_quaternion(roll, pitch, heading)
        twist.linear.z, twist.angular.x, twist.angular.y = estimate.vertical.velocity.tolist()
    return message


def to_state(estimate: ObserverEstimate, stamp: int) -> ObserverState:
    """Return what the observer knows beside the odometry."""
    message = ObserverState(
        valid=estimate.valid,
        status=str(estimate.status),
        time_since_measurement=estimate.time_since_measurement,
        wave_frequency_position=estimate.wave_frequency_position,
        bias=estimate.bias,
        innovation=estimate.innovation,
    )
    if estimate.vertical is not None:
        message.vertical_bias = array("d", estimate.vertical.bias.tobytes())
        message.vertical_innovation = array("d", estimate.vertical.innovation.tobytes())
    message.header.stamp = from_nanoseconds(stamp)
    message.header.frame_id = MAP_FRAME
    return message
