"""Quaternions that give back a heading to the bit."""

from __future__ import annotations

import math

from marine_model.frames import heading_to_quaternion, quaternion_to_heading

# A heading that has been a quaternion before is at most this many units in its last place from the one it came from:
# sine, cosine, three products and arctangent are each within about one, and doubled where half angles are.
_UNITS = 16


def exact_quaternion(heading: float) -> tuple[float, float]:
    """Return (z, w) of the quaternion by which ``heading`` (rad, in [-pi, pi]) was sent.

    Half the angle and back is not exact: of the headings next to this one, the quaternion of some one is read as
    ``heading``. A heading that has never been a quaternion may have none; then that of ``heading`` itself is as near as
    there is.
    """
    up = down = heading
    for _ in range(_UNITS):
        for near in (up, down):
            _, _, z, w = heading_to_quaternion(near)
            if quaternion_to_heading(0.0, 0.0, z, w) == heading:
                return z, w
        up, down = math.nextafter(up, math.inf), math.nextafter(down, -math.inf)
    _, _, z, w = heading_to_quaternion(heading)
    return z, w
