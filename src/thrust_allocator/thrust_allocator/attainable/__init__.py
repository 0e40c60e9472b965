"""The exact set of generalized forces that the thrusters can give, at given angles and when they turn."""

from thrust_allocator.attainable.axes_margin import AxesMargin
from thrust_allocator.attainable.ball import Ball, largest_ball
from thrust_allocator.attainable.force_set import ForceSet, force_set
from thrust_allocator.attainable.margin import Margin, ThrustMargin
from thrust_allocator.attainable.outline import AXES, projection, section
from thrust_allocator.attainable.scale import scale_to_boundary
from thrust_allocator.attainable.volume import volume
from thrust_allocator.attainable.zonotope import Facets, facets, zonotope_scale, zonotope_volume

__all__ = [
    "AXES",
    "AxesMargin",
    "Ball",
    "Facets",
    "ForceSet",
    "Margin",
    "ThrustMargin",
    "facets",
    "force_set",
    "largest_ball",
    "projection",
    "scale_to_boundary",
    "section",
    "volume",
    "zonotope_scale",
    "zonotope_volume",
]
