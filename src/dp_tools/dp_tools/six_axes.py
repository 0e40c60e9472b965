"""What an operator gives in three numbers on the surface and in six below, as the parts of a message."""

from __future__ import annotations

from collections.abc import Sequence

from marine_model.frames import attitude_to_quaternion, heading_to_quaternion

Point = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def pose_parts(position: Sequence[float]) -> tuple[Point, Quaternion]:
    """Return point and quaternion of north, east, heading; or of north, east, depth, roll, pitch, heading."""
    if len(position) == 3:
        north, east, heading = position
        return (north, east, 0.0), heading_to_quaternion(heading)
    north, east, depth, roll, pitch, heading = position
    return (north, east, depth), attitude_to_quaternion(roll, pitch, heading)


def wrench_parts(force: Sequence[float]) -> tuple[Point, Point]:
    """Return force and moment of surge, sway, yaw; or of surge, sway, heave, roll, pitch, yaw."""
    if len(force) == 3:
        surge, sway, yaw = force
        return (surge, sway, 0.0), (0.0, 0.0, yaw)
    surge, sway, heave, roll, pitch, yaw = force
    return (surge, sway, heave), (roll, pitch, yaw)
