"""Limit of the power of one bus as one linear row, [Ruth] (4.50)-(4.55).

The power m |T|^(3/2) is convex in T, and in (T_x, T_y). Each thruster is described by one number x: its thrust when it
is allocated along a fixed direction, and the part of its thrust along its present direction, x = cos(alpha_0) T_x +
sin(alpha_0) T_y, when it rotates. A row is sum_j s_j x_j <= b.

Tangent row, what (4.52)-(4.55) are meant to be: the gradient of m (T_x^2 + T_y^2)^(3/4) at T_0 is

    (3/2) m (T_0x^2 + T_0y^2)^(-1/4) (T_0x, T_0y),     s_j = (3/2) m_j sqrt|T_0,j| sign(T_0,j),

and as T_0 lies on x, sum_j s_j x_j <= P_bus + sum_j (1/2) m_j |T_0,j|^(3/2). The print has the exponent -1/4 in a
denominator and 3/4 in the numerator, 2 for the 3/4 2 of the chain rule, no constant term in (4.52), and has lost the
variables and P_bus in (4.54)-(4.55). A tangent lies below a convex function: the row cuts off nothing that is allowed,
but allows more than P_bus. With |z_j - z_0,j| <= d_j in the step the excess is at most sum_j m_j sqrt(1 + 1/sqrt 2)
d_j^(3/2), :func:`tangent_excess`. At T_0 = 0 the tangent is zero and the row empty.

Safe row, the default: a line above the power everywhere in the window of the step. For a fixed thruster it is the
chord over [T_-, T_+]. For a rotating one every linear function that is above the power at the vertices of its polygon
is above it in the whole polygon; of those that depend on x alone, taken is the one that is lowest at the present
thrust, which is an edge of the upper hull of the points (x_i, m |z_i|^(3/2)) over the vertices z_i. The chord is the
same with two vertices. It is above by no more than m h^(3/2), h half of the width of the window, for a fixed thruster,
so that the bus is never exceeded, and used less than fully while thrust may still change.

Which row is used: the safe one; where it would take more than the fraction c_1 of what the step can reach, the
tangent; where that would too, the bus takes more than its limit now and cannot come back in this step, and the row
asks for the fraction c_1, as (4.14)-(4.17) do. Where the row is not safe,
:func:`~thrust_allocator.power.total.phase_back` of the thrusters of the bus brings the answer down to the limit,
exactly.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.plan.polygon import CORNERS, rotating_corners

# sup over T_0 of |T_0 - 1|^(3/2) - |T_0|^(3/2) + (3/2) sqrt|T_0|, at T_0 = (2 - sqrt 2) / 4: how far |T|^(3/2) rises
# above its tangent one unit away. Off the line through the origin it is less: at equal |z| it depends on the distance
# alone.
TANGENT_EXCESS = math.sqrt(1.0 + math.sqrt(0.5))


class BusRowKind(IntEnum):
    """How a row was made."""

    SAFE = 0  # the bus limit holds wherever the row does
    TANGENT = 1  # linearised; may be exceeded by `tangent_excess`
    RELAXED = 2  # the limit is out of reach in this step


@compiled
def power_of(coefficient: float, thrust: float) -> float:
    """Return m |T|^(3/2), W, for m in W / N^(3/2) and T in N."""
    size = abs(thrust)
    return coefficient * size * math.sqrt(size)


@compiled
def tangent_excess(coefficient: FloatArray, member: FloatArray, reach: FloatArray) -> float:
    """Return the most by which a tangent row lets a bus exceed its limit in one step, W.

    Parameters
    ----------
    coefficient
        m, shape (n,), W / N^(3/2).
    member
        Shape (n,), 1 for the thrusters of the bus, 0 for others.
    reach
        Largest change of the thrust vector in one step, shape (n,), N: for a fixed thruster its rate times the step.
    """
    total = 0.0
    for j in range(member.size):
        if member[j] > 0.0:
            total += TANGENT_EXCESS * coefficient[j] * reach[j] ** 1.5
    return total


@compiled
def line_above(x: FloatArray, y: FloatArray, at: float) -> tuple[float, float]:
    """Return slope and value at zero of the line that is above all points and lowest at ``at``.

    Parameters
    ----------
    x, y
        Points, shape (k,).
    at
        Where the line is to be low; brought a little inside the range of x, where only one line is lowest.
    """
    k = x.size
    first, last = x.min(), x.max()
    inset = 1e-3 * (last - first)
    at = min(max(at, first + inset), last - inset)
    slope, offset = 0.0, y.max()
    best = offset
    for i in range(k):
        for j in range(k):
            if x[i] < x[j]:
                s = (y[j] - y[i]) / (x[j] - x[i])
                o = y[i] - s * x[i]
                for p in range(k):
                    o = max(o, y[p] - s * x[p])
                if o + s * at < best:
                    best, slope, offset = o + s * at, s, o
    return slope, offset


@compiled
def bus_row(
    coefficient: FloatArray,
    member: FloatArray,
    rotating: FloatArray,
    thrust: FloatArray,
    azimuth: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    turn_low: FloatArray,
    turn_high: FloatArray,
    zero_region: float,
    limit: float,
    approach: float,
    safe: bool,
    row_x: FloatArray,
    row_y: FloatArray,
) -> tuple[float, int]:
    """Write the row of one bus: sum_j row_x_j T_x,j + row_y_j T_y,j <= b, and row_x_j T_j for a fixed thruster.

    Parameters
    ----------
    coefficient
        m, shape (n,), W / N^(3/2), times the correction of (4.44) where there is one.
    member
        Shape (n,), 1 for the thrusters of the bus, 0 for others.
    rotating
        Shape (n,), 1 where the unknowns are T_x and T_y, 0 where it is the thrust along a fixed direction.
    thrust, azimuth
        Commands of the step before, shape (n,), N and rad.
    lower, upper
        T_- and T_+, shape (n,), N.
    turn_low, turn_high
        Azimuth window of a rotating thruster relative to ``azimuth``, shape (n,), rad, each within 90 deg.
    zero_region
        c_2.
    limit
        P_bus, W, finite, 0 or more.
    approach
        c_1, in [0, 1).
    safe
        False for the thesis's tangent row.
    row_x, row_y
        Shape (n,), W/N; written for all thrusters, zero for those of other buses.

    Returns
    -------
    tuple of float and int
        b (W) and the :class:`BusRowKind`.
    """
    n = thrust.size
    corners = np.empty((CORNERS, 2))
    x, y = np.empty(CORNERS), np.empty(CORNERS)
    least = np.empty(n)
    most = np.empty(n)
    now = np.empty(n)
    slope = np.zeros(n)
    bound = limit
    kind = 0
    present, reached = 0.0, 0.0
    for j in range(n):
        if member[j] == 0.0:
            continue
        # A thrust outside its window (a limit was lowered) is left behind in this step.
        now[j] = min(max(thrust[j], lower[j]), upper[j])
        least[j], most[j] = lower[j], upper[j]
        count = 2
        if rotating[j] > 0.0:
            # Seen along the present direction.
            count = rotating_corners(0.0, turn_low[j], turn_high[j], lower[j], upper[j], zero_region, corners)
            for i in range(count):
                x[i] = corners[i, 0]
                y[i] = power_of(coefficient[j], math.hypot(corners[i, 0], corners[i, 1]))
                least[j], most[j] = min(least[j], x[i]), max(most[j], x[i])
        else:
            x[0], x[1] = lower[j], upper[j]
            y[0], y[1] = power_of(coefficient[j], lower[j]), power_of(coefficient[j], upper[j])
        slope[j], offset = line_above(x[:count], y[:count], now[j])
        bound -= offset
        present += slope[j] * now[j]
        reached += min(slope[j] * least[j], slope[j] * most[j])
    # The fraction c_1 of the way to what the step can reach leaves the row some width.
    if not safe or present + approach * (reached - present) > bound:
        kind = 1
        bound, present, reached = limit, 0.0, 0.0
        for j in range(n):
            if member[j] == 0.0:
                continue
            slope[j] = 1.5 * coefficient[j] * math.copysign(math.sqrt(abs(now[j])), now[j])
            bound += 0.5 * power_of(coefficient[j], now[j])
            present += slope[j] * now[j]
            reached += min(slope[j] * least[j], slope[j] * most[j])
        relaxed = present + approach * (reached - present)
        if relaxed > bound:
            kind = 2
            bound = relaxed
    for j in range(n):
        row_x[j], row_y[j] = 0.0, 0.0
        if member[j] > 0.0:
            row_x[j] = slope[j]
            if rotating[j] > 0.0:
                row_x[j] = slope[j] * math.cos(azimuth[j])
                row_y[j] = slope[j] * math.sin(azimuth[j])
    return bound, kind
