"""The exact set of generalized forces that the thrusters can give, at given angles and when they turn."""

from thrust_allocator.attainable.ball import Ball, largest_ball
from thrust_allocator.attainable.force_set import ForceSet, force_set
from thrust_allocator.attainable.margin import Margin, ThrustMargin, scale_to_boundary
from thrust_allocator.attainable.outline import AXES, projection, section
from thrust_allocator.attainable.volume import volume

__all__ = [
    "AXES",
    "Ball",
    "ForceSet",
    "Margin",
    "ThrustMargin",
    "force_set",
    "largest_ball",
    "projection",
    "scale_to_boundary",
    "section",
    "volume",
]
