"""What a wave component does to the hull, tabulated over the relative direction of the waves.

A table has shape (m, NODES, 2 FUNCTIONS): for every component and every node, evenly spaced over relative directions
b = beta - heading from 0 to pi, the values of FUNCTIONS functions of b and then their slopes times the distance of the
nodes. Between two nodes the cubic that fits values and slopes at both (Hermite) is taken: continuous, with a
continuous slope. A hull is symmetric: for b < 0, sway, roll and yaw change their sign.

First-order motion X is complex, x(t) = a Re[X exp(i theta)]: surge, sway, heave per metre, roll, pitch, yaw in rad/m.
Drift is the mean force over the amplitude squared: N/m^2, N/m^2, N/m. Both in the body axes.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import inlined
from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Functions: real and imaginary part of every motion, then drift.
SURGE_RE, SURGE_IM, SWAY_RE, SWAY_IM, HEAVE_RE, HEAVE_IM = range(6)
ROLL_RE, ROLL_IM, PITCH_RE, PITCH_IM, YAW_RE, YAW_IM = range(6, 12)
DRIFT_X, DRIFT_Y, DRIFT_N = range(12, 15)
FUNCTIONS = 15
ODD = (SWAY_RE, SWAY_IM, ROLL_RE, ROLL_IM, YAW_RE, YAW_IM, DRIFT_Y, DRIFT_N)
EVEN = tuple(sorted(set(range(FUNCTIONS)) - set(ODD)))

NODES = 181  # a degree between two
NODE_DIRECTIONS: FloatArray = np.linspace(0.0, math.pi, NODES)

_TWO_PI = 2.0 * math.pi
_NODES_PER_RADIAN = (NODES - 1) / math.pi


def response_table(direction: FloatArray, values: FloatArray) -> FloatArray:
    """Return the table of functions known at some relative directions.

    Between those a cubic spline is taken. Even functions have no slope at 0 and pi, as symmetry says.

    Parameters
    ----------
    direction
        b, rad, increasing from 0 to pi, shape (nb,).
    values
        Shape (m, nb, FUNCTIONS).

    Raises
    ------
    InputError
        If the directions do not begin at 0 or do not end at pi.
    """
    from scipy.interpolate import CubicSpline  # here: its import is slow

    if direction.size < 2 or abs(direction[0]) > 1e-9 or abs(direction[-1] - math.pi) > 1e-9:
        raise InputError(f"direction: expected relative directions from 0 to pi, found {direction.tolist()}")
    table = np.empty((values.shape[0], NODES, 2 * FUNCTIONS))
    for functions, ends in ((EVEN, "clamped"), (ODD, "not-a-knot")):
        columns = np.array(functions)
        spline = CubicSpline(direction, values[:, :, columns], axis=1, bc_type=ends)
        table[:, :, columns] = spline(NODE_DIRECTIONS)
        table[:, :, FUNCTIONS + columns] = spline(NODE_DIRECTIONS, 1) / _NODES_PER_RADIAN
    return table


@inlined
def between(b: float) -> tuple[int, float, float, float, float, float]:
    """Return node, weights of values and slopes at it and at the next, and the sign of odd functions, at ``b``."""
    b -= _TWO_PI * math.floor(b / _TWO_PI + 0.5)
    sign = 1.0
    if b < 0.0:
        b, sign = -b, -1.0
    place = b * _NODES_PER_RADIAN
    node = min(int(place), NODES - 2)
    t = place - node
    u = 1.0 - t
    return node, (1.0 + 2.0 * t) * u * u, (3.0 - 2.0 * t) * t * t, t * u * u, -t * t * u, sign


@inlined
def value(
    table: FloatArray, i: int, node: int, function: int, here: float, there: float, slope: float, slope_there: float
) -> float:
    """Return one function of component ``i`` with what ``between`` gave."""
    found: float = (
        here * table[i, node, function]
        + there * table[i, node + 1, function]
        + slope * table[i, node, FUNCTIONS + function]
        + slope_there * table[i, node + 1, FUNCTIONS + function]
    )
    return found
