"""Constraints of a rotating thruster in Cartesian coordinates, [Ruth] (4.38)-(4.42) and Figure 4.3."""

from __future__ import annotations

from math import cos, sin

ROWS = 5

Row = tuple[float, float, float]


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
        Ends of the window relative to ``azimuth``, alpha_- - alpha_0 and alpha_+ - alpha_0, rad; each less than
        90 deg from it, and together less than 180 deg.
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
