"""Reference frames: north-east-down (NED) and body (forward-starboard-down).

In three degrees of freedom positions are ``eta = [north (m), east (m), heading (rad)]``, velocities ``nu = [surge
(m/s), sway (m/s), yaw rate (rad/s)]``; ``eta_dot = R(heading) nu`` (Fossen, *Handbook of Marine Craft*, 3-DOF
kinematics). In six, an attitude is roll, pitch and heading: the body is turned about the down axis by the heading,
then about its own axis to starboard by the pitch, then about its own axis ahead by the roll (z-y-x).
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray

MAP_FRAME = "map_ned"
BODY_FRAME = "base_link_frd"

_TWO_PI = 2.0 * math.pi


def wrap_angle(angle: float) -> float:
    """Return ``angle`` (rad) wrapped to [-pi, pi)."""
    wrapped = (angle + math.pi) % _TWO_PI - math.pi
    # The sum rounds up to exactly 2 pi for tiny negative remainders.
    return -math.pi if wrapped >= math.pi else wrapped


def wrap_angles(angles: FloatArray) -> FloatArray:
    """Return ``angles`` (rad, any shape) wrapped to [-pi, pi), elementwise."""
    wrapped = np.mod(angles + math.pi, _TWO_PI) - math.pi
    return np.where(wrapped >= math.pi, -math.pi, wrapped)


def rotation(heading: float) -> FloatArray:
    """Return R(heading), shape (3, 3): body vector to NED vector, yaw unchanged."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def heading_to_quaternion(heading: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a rotation by ``heading`` (rad) about the down axis."""
    return 0.0, 0.0, math.sin(0.5 * heading), math.cos(0.5 * heading)


def quaternion_to_heading(x: float, y: float, z: float, w: float) -> float:
    """Return the heading (rad, in [-pi, pi]) of a quaternion, its yaw of the z-y-x sequence.

    Raises
    ------
    InputError
        If a component is not finite or the norm is not 1 within 1 %.
    """
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not math.isfinite(norm) or abs(norm - 1.0) > 0.01:
        raise InputError(f"orientation: expected a unit quaternion, found ({x}, {y}, {z}, {w})")
    # This form does not depend on the norm, the common one with 1 - 2 (y^2 + z^2) does.
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def attitude_rotation(roll: float, pitch: float, heading: float) -> FloatArray:
    """Return R(roll, pitch, heading), shape (3, 3): body vector to NED vector."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    ch, sh = math.cos(heading), math.sin(heading)
    return np.array(
        [
            [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
            [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def attitude_to_quaternion(roll: float, pitch: float, heading: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of an attitude (rad); without roll and pitch, that of the heading."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    ch, sh = math.cos(0.5 * heading), math.sin(0.5 * heading)
    return (
        sr * cp * ch - cr * sp * sh,
        cr * sp * ch + sr * cp * sh,
        cr * cp * sh - sr * sp * ch,
        cr * cp * ch + sr * sp * sh,
    )


def quaternion_to_attitude(x: float, y: float, z: float, w: float) -> tuple[float, float, float]:
    """Return roll, pitch and heading (rad) of a quaternion.

    Roll and heading are in [-pi, pi], pitch in [-pi/2, pi/2]; the heading is that of :func:`quaternion_to_heading`.
    With the bow straight up or down only the sum or the difference of roll and heading means anything.

    Raises
    ------
    InputError
        As :func:`quaternion_to_heading`.
    """
    heading = quaternion_to_heading(x, y, z, w)
    # These forms do not depend on the norm either.
    up = 2.0 * (w * y - x * z)
    across = math.hypot(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    roll = math.atan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    return roll, math.atan2(up, across), heading
