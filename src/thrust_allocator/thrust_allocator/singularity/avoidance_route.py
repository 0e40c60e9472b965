"""By which way, and at what price, to turn from one configuration to another: question (b) of [Ruth] 8.2."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, gain_at, static_cost

# Points of the lattice between start and target, at most; longer turns are cut coarser.
_LARGEST_LATTICE = 1500
_STILL = 1e-9  # rad


class Route(NamedTuple):
    """A way through the angles.

    Attributes
    ----------
    azimuth
        Angles at equal times, shape (k, n), rad, not wrapped; start first.
    spacing
        Time between them, s.
    price
        Time, s, with what is below the gain limit weighted.
    least_gain
        On the way, ends included.
    """

    azimuth: FloatArray
    spacing: float
    price: float
    least_gain: float

    @property
    def duration(self) -> float:
        """Time it takes, s."""
        return self.spacing * (len(self.azimuth) - 1)


class Toll(NamedTuple):
    """What a route costs.

    Attributes
    ----------
    excess
        Integral over the route of the cost above that of its end, N^2 s.
    shortfall
        Largest scaled generalized force that is missing for the demand with its margin.
    """

    excess: float
    shortfall: float


def find_route(
    thrusters: Thrusters,
    start: FloatArray,
    target: FloatArray,
    low: FloatArray,
    high: FloatArray,
    rate: FloatArray,
    threshold: float,
    weight: float,
    spacing: float,
) -> Route | None:
    """Return the cheapest route; None if no way round is allowed.

    Every thruster turns one way, the shorter or the longer, at full rate or not at all; which waits for which is
    found by dynamic programming over the lattice of what each has turned so far. A second counts once, and
    ``weight`` (1 + (sigma_lim - sigma) / sigma_lim) times more below the limit.

    Parameters
    ----------
    thrusters
        As in :func:`gain_at`.
    start, target
        Shape (n,), rad.
    low, high
        How far each may turn from ``start``, rad.
    rate
        Shape (n,), rad/s.
    threshold
        sigma_lim.
    weight
        Seconds of turning that are worth one second less below the limit.
    spacing
        Least time between two points, s.
    """
    n = len(start)
    ways: list[list[tuple[float, float]]] = []
    for j in thrusters.turning.tolist():
        turn = math.remainder(target[j] - start[j], 2.0 * math.pi)
        turns = [turn] if abs(turn) < _STILL else [turn, turn - math.copysign(2.0 * math.pi, turn)]
        ways.append([(abs(t) / rate[j], t) for t in turns if low[j] <= t <= high[j]])
    if not all(ways):
        return None
    best: Route | None = None
    for way in sorted(itertools.product(*ways), key=lambda way: max((time for time, _ in way), default=0.0)):
        longest = max((time for time, _ in way), default=0.0)
        if best is not None and longest >= best.price:
            break
        turn_of = np.zeros(n)
        turn_of[thrusters.turning] = [t for _, t in way]
        cells, step = _lattice(np.array([time for time, _ in way]), spacing)
        waypoints = np.empty((int(cells.sum()) + 1, n))
        length, price, least = _cheapest(thrusters, start, turn_of, cells, threshold, weight, waypoints)
        route = Route(waypoints[:length].copy(), step, price * step, least)
        if best is None or route.price < best.price:
            best = route
    return best


def _lattice(times: FloatArray, spacing: float) -> tuple[IntArray, float]:
    """Return how many steps each thruster takes, and how long one is."""
    step = spacing
    while True:
        cells = np.ceil(times / step - 1e-9).astype(np.int64)
        if np.prod(cells + 1.0) <= _LARGEST_LATTICE:
            return cells, step
        step *= 1.1


@compiled
def _cheapest(
    thrusters: Thrusters,
    start: FloatArray,
    turn: FloatArray,
    cells: IntArray,
    threshold: float,
    weight: float,
    waypoints: FloatArray,
) -> tuple[int, float, float]:
    """Write the cheapest way through the lattice; return its number of points, its price in steps, its least gain."""
    turning = thrusters.turning
    r = len(turning)
    stride = np.empty(r, dtype=np.int64)
    total = 1
    for i in range(r):
        stride[i] = total
        total *= cells[i] + 1
    value, gains = np.empty(total), np.empty(total)
    following = np.full(total, -1, dtype=np.int64)
    at, unused = start.copy(), np.empty(3)
    for node in range(total - 1, -1, -1):
        for i in range(r):
            if cells[i] > 0:
                done = (node // stride[i]) % (cells[i] + 1)
                at[turning[i]] = start[turning[i]] + turn[turning[i]] * done / cells[i]
        gains[node] = gain_at(thrusters, at, unused)
        price = 1.0
        if gains[node] < threshold:
            price += weight * (2.0 - gains[node] / threshold)
        if node == total - 1:
            value[node] = price
            continue
        least = math.inf
        # Every set of thrusters may move; moving more of them comes last and wins where prices are equal.
        for moving in range(1, 1 << r):
            to = node
            possible = True
            for i in range(r):
                if (moving >> i) & 1:
                    if (node // stride[i]) % (cells[i] + 1) == cells[i]:
                        possible = False
                        break
                    to += stride[i]
            if possible and value[to] <= least:
                least = value[to]
                following[node] = to
        value[node] = price + least
    node, length, least_gain = 0, 0, math.inf
    while node >= 0:
        for j in range(len(start)):
            waypoints[length, j] = start[j]
        for i in range(r):
            if cells[i] > 0:
                done = (node // stride[i]) % (cells[i] + 1)
                waypoints[length, turning[i]] = start[turning[i]] + turn[turning[i]] * done / cells[i]
        least_gain = min(least_gain, gains[node])
        length += 1
        node = following[node]
    # Between the points too.
    for k in range(length - 1):
        for j in range(len(start)):
            at[j] = 0.5 * (waypoints[k, j] + waypoints[k + 1, j])
        least_gain = min(least_gain, gain_at(thrusters, at, unused))
    return length, value[0], least_gain


def toll_of(thrusters: Thrusters, route: Route, tau: FloatArray, margin: float, scale: FloatArray) -> Toll:
    """Return what ``route`` costs at the demand ``tau``, if it stands.

    Parameters
    ----------
    thrusters
        As in :func:`static_cost`.
    route
        From :func:`find_route`.
    tau
        Demand, shape (3,), N, N, N m.
    margin
        Length of what may come on top of the demand along the direction of least gain, scaled.
    scale
        Scaled generalized force of a unit of each axis, shape (3,).
    """
    excess, shortfall = _toll(thrusters, route.azimuth, tau, margin, scale)
    return Toll(excess * route.spacing, shortfall)


@compiled
def _toll(
    thrusters: Thrusters, waypoints: FloatArray, tau: FloatArray, margin: float, scale: FloatArray
) -> tuple[float, float]:
    n = waypoints.shape[1]
    u, multiplier, thrust, demand = np.empty(3), np.zeros(3), np.empty(n), np.empty(3)
    last = len(waypoints) - 1
    end = static_cost(thrusters, waypoints[last], tau, multiplier, thrust)
    excess, shortfall = 0.0, 0.0
    for k in range(last):
        multiplier[:] = 0.0
        excess += max(static_cost(thrusters, waypoints[k], tau, multiplier, thrust) - end, 0.0)
        gain_at(thrusters, waypoints[k], u)
        for sign in (-1.0, 1.0):
            for a in range(3):
                demand[a] = tau[a] + sign * margin * u[a] / scale[a]
            multiplier[:] = 0.0
            static_cost(thrusters, waypoints[k], demand, multiplier, thrust)
            missing = 0.0
            for a in range(3):
                missing += (multiplier[a] * thrusters.compliance[a] * scale[a]) ** 2
            shortfall = max(shortfall, math.sqrt(missing))
    return excess, shortfall
