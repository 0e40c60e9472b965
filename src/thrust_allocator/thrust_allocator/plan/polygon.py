"""Constraints of a rotating thruster in Cartesian coordinates, [Ruth] (4.38)-(4.42) and Figure 4.3."""

from __future__ import annotations

from math import cos, sin

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

ROWS = 5
# Corners of that polygon, at most.
CORNERS = 5
# Shortest side of a cone as a share of the height of the polygon.
_SHORTEST = 1e-9

Row = tuple[float, float, float]


@compiled
def rotating_rows(
    azimuth: float,
    turn_low: float,
    turn_high: float,
    thrust_lower: float,
    thrust_upper: float,
    zero_region: float,
) -> tuple[Row, Row, Row, Row, Row]:
    """Return five rows (a_x, a_y, b), each meaning a_x T_x + a_y T_y <= b with (a_x, a_y) of length 1.

    In order: the two ends of the azimuth window (4.38)-(4.39), least thrust (4.40), and the two lines of largest
    thrust (4.41)-(4.42), which meet on the present direction and so favour it in saturation. The convex polygon they
    bound lies inside the arcs of the true limits, but for the small region about zero in which a thruster may turn
    without thrust.

    That region reaches c_2 (T_+ - T_-) beyond both sides of the cone. (4.38)-(4.39) print c_2 |cos(alpha)| in place of
    c_2, which would take it away where an end of the window points athwartships: a thruster there at zero thrust
    could not leave its cone and would be stuck. The rows have length 1, so that a distance from the line needs no
    factor; the region is then the same in every direction.

    Astern it reaches as far, and not to a smaller T_-: there the two sides meet in a point exactly opposite to the
    present direction, which would be the answer to most demands and say nothing of the side on which to turn.

    Parameters
    ----------
    azimuth
        Present direction alpha_0, rad.
    turn_low, turn_high
        Ends of the window relative to ``azimuth``, alpha_- - alpha_0 <= 0 and alpha_+ - alpha_0 >= 0, rad; each less
        than 90 deg from it, and together less than 180 deg.
    thrust_lower, thrust_upper
        T_- and T_+, N.
    zero_region
        c_2.
    """
    low, high = azimuth + turn_low, azimuth + turn_high
    cos_low, sin_low = cos(low), sin(low)
    cos_high, sin_high = cos(high), sin(high)
    width = zero_region * (thrust_upper - thrust_lower)
    return (
        (sin_low, -cos_low, width),
        (-sin_high, cos_high, width),
        (-cos(azimuth), -sin(azimuth), min(-thrust_lower, width)),
        (cos_low, sin_low, cos(turn_low) * thrust_upper),
        (cos_high, sin_high, cos(turn_high) * thrust_upper),
    )


@compiled
def rotating_corners(
    azimuth: float,
    turn_low: float,
    turn_high: float,
    thrust_lower: float,
    thrust_upper: float,
    zero_region: float,
    corners: FloatArray,
) -> int:
    """Write the corners of the polygon of :func:`rotating_rows` and return how many there are, 3 to 5.

    They go round with rising angle. Arguments as there; ``corners`` has shape (5, 2) or more rows, body frame, N.
    """
    cos_low, sin_low = cos(turn_low), sin(turn_low)
    cos_high, sin_high = cos(turn_high), sin(turn_high)
    width = zero_region * (thrust_upper - thrust_lower)
    # In a frame whose x axis is the present direction, the line of least thrust is x = back.
    back = -min(-thrust_lower, width)
    x, y = corners[:, 0], corners[:, 1]
    # A side that is shorter than this has no direction but rounding's; the line of least thrust then cuts it off.
    least = back + _SHORTEST * (thrust_upper - back)
    # Where a side of the window meets its line of largest thrust, at a right angle.
    side_x = thrust_upper * cos_low * cos_low + width * sin_low
    k = 0
    if side_x > least:
        x[0], y[0] = back, (sin_low * back - width) / cos_low
        x[1], y[1] = side_x, thrust_upper * cos_low * sin_low - width * cos_low
        k = 2
    elif sin_low < 0.0:
        # The line of least thrust cuts the side off.
        x[0], y[0] = back, cos_low * (thrust_upper - back) / sin_low
        k = 1
    x[k], y[k] = thrust_upper, 0.0
    k += 1
    side_x = thrust_upper * cos_high * cos_high - width * sin_high
    if side_x > least:
        x[k], y[k] = side_x, thrust_upper * cos_high * sin_high + width * cos_high
        x[k + 1], y[k + 1] = back, (sin_high * back + width) / cos_high
        k += 2
    elif sin_high > 0.0:
        x[k], y[k] = back, cos_high * (thrust_upper - back) / sin_high
        k += 1
    c, s = cos(azimuth), sin(azimuth)
    for i in range(k):
        x_i, y_i = x[i], y[i]
        x[i] = c * x_i - s * y_i
        y[i] = s * x_i + c * y_i
    return k
