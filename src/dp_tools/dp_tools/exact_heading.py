"""Quaternions that give back a heading to the bit."""

from __future__ import annotations

import math

from marine_model.frames import heading_to_quaternion, quaternion_to_heading

# Units in the last place that sine, cosine, the reader's products and its arctangent can add up to.
_UNITS = 4


def exact_quaternion(heading: float) -> tuple[float, float]:
    """Return (z, w) of a quaternion that is read as ``heading`` (rad, in [-pi, pi]).

    To a quaternion and back is not exact, and which neighbour comes out depends on the turns that were in the heading
    when it was sent. So the quaternions within some units in the last place of (sin, cos) of half the heading are
    tried, the nearest first. If none of them is read as ``heading``, that of ``heading`` itself is as near as there is.
    """
    _, _, z, w = heading_to_quaternion(heading)
    for distance in range(2 * _UNITS + 1):
        for i in range(-distance, distance + 1):
            for j in {distance - abs(i), abs(i) - distance}:
                near = z + i * math.ulp(z), w + j * math.ulp(w)
                if quaternion_to_heading(0.0, 0.0, *near) == heading:
                    return near
    return z, w
