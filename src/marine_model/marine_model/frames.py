"""Reference frames in three degrees of freedom: north-east-down (NED) and body (forward-starboard-down).

Positions are ``eta = [north (m), east (m), heading (rad)]``, velocities ``nu = [surge (m/s), sway (m/s),
yaw rate (rad/s)]``; ``eta_dot = R(heading) nu`` (Fossen, *Handbook of Marine Craft*, 3-DOF kinematics).
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
