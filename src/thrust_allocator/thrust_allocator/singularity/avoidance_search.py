"""The best of all configurations with sufficient gain: a grid over the angles, and a bound that spares most of it."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.singularity.avoidance_descent import descend
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, gain_at, static_cost
from thrust_allocator.singularity.settings import MOST_TURNING

# Points a half turn, by the number of thrusters that turn, up to MOST_TURNING: at most 10,000 in all.
_POINTS = (1, 48, 36, 18, 10)
# Exact costs computed in one search, at most; each may need every way of pointing its thrusters fore or aft.
_EVALUATIONS = 40
# The same of points in the order of the grid, so that a standing demand has the whole grid searched in time: where
# thrusters saturate the bound says little.
_ROLLING = 30
_POLISH_STEPS = 30


class Grid:
    """Gains over half a turn of every thruster that can turn: a thruster the other way round has the same gain.

    Parameters
    ----------
    thrusters
        Which can turn and how strong they are. Their weights are not used.
    azimuth
        Angles of those that cannot turn, shape (n,), rad.

    Raises
    ------
    InputError
        If more than four thrusters turn.
    """

    def __init__(self, thrusters: Thrusters, azimuth: FloatArray) -> None:
        turning = len(thrusters.turning)
        if turning > MOST_TURNING:
            raise InputError(
                f"singularity.method: expected at most {MOST_TURNING} azimuth thrusters for a search over their "
                f"angles, found {turning}"
            )
        self.points = _POINTS[turning]
        self.gains = np.empty(self.points**turning)
        _grid_gains(thrusters, azimuth, self.points, self.gains)
        self.best_gain = float(self.gains.max())
        self._sufficient = np.empty(0, dtype=np.int64)
        self._threshold = math.nan
        self._incumbent = azimuth.copy()
        self._cursor = 0

    def sufficient(self, threshold: float) -> IntArray:
        """Return the indices of points with that gain or more."""
        if threshold != self._threshold:
            self._sufficient = np.flatnonzero(self.gains >= threshold)
            self._threshold = threshold
        return self._sufficient

    def best(
        self,
        thrusters: Thrusters,
        azimuth: FloatArray,
        low: FloatArray,
        high: FloatArray,
        tau: FloatArray,
        threshold: float,
    ) -> tuple[FloatArray, float]:
        """Return the cheapest configuration with sufficient gain and its cost; infinite where none can be reached.

        The work of one call is limited: points in the order of a lower bound of their cost, some more in the order of
        the grid, going on where the last call ended, and the best of the last call again.

        Parameters
        ----------
        thrusters, tau
            As in :func:`static_cost`.
        azimuth
            Present angles, shape (n,), rad; of equal configurations the nearer is taken.
        low, high
            How far each may turn from there, rad; below -pi and above pi for the whole circle.
        threshold
            Least gain.
        """
        nodes = self.sufficient(threshold)
        found = azimuth.copy()
        cost = math.inf
        turns = np.array([math.remainder(t, 2.0 * math.pi) for t in (self._incumbent - azimuth).tolist()])
        last = azimuth + turns
        if (turns >= low).all() and (turns <= high).all() and gain_at(thrusters, last, np.empty(3)) >= threshold:
            found = last
            cost = static_cost(thrusters, last, tau, np.zeros(3), np.empty(len(last)))
        cost, self._cursor = _best_node(
            thrusters, azimuth, low, high, self.points, nodes, tau, found, cost, self._cursor
        )
        if math.isfinite(cost):
            ahead = np.minimum(np.maximum(azimuth + high - found, 0.0), math.pi)
            astern = np.maximum(np.minimum(azimuth + low - found, 0.0), -math.pi)
            cost = descend(thrusters, tau, threshold, astern, ahead, _POLISH_STEPS, found)
            self._incumbent = found.copy()
        return found, cost

    def nearest(
        self,
        thrusters: Thrusters,
        azimuth: FloatArray,
        low: FloatArray,
        high: FloatArray,
        rate: FloatArray,
        threshold: float,
    ) -> FloatArray:
        """Return the configuration with sufficient gain that takes least time to turn to; the present one if none.

        Of several, the one with the greatest gain. ``rate``: shape (n,), rad/s; others as in :meth:`best`.
        """
        found = azimuth.copy()
        _nearest_node(thrusters, azimuth, low, high, rate, self.points, self.sufficient(threshold), self.gains, found)
        return found


@compiled
def _angles_of(node: int, points: int, turning: IntArray, azimuth: FloatArray) -> None:
    for j in turning:
        azimuth[j] = (node % points) * math.pi / points
        node //= points


@compiled
def _grid_gains(thrusters: Thrusters, azimuth: FloatArray, points: int, gains: FloatArray) -> None:
    at, unused = azimuth.copy(), np.empty(3)
    for node in range(len(gains)):
        _angles_of(node, points, thrusters.turning, at)
        gains[node] = gain_at(thrusters, at, unused)


@compiled
def _nearer(turn: float, low: float, high: float) -> float:
    """Return ``turn`` or what differs from it by half turns: the least that is allowed; NaN if none is."""
    turn -= math.pi * math.floor(turn / math.pi + 0.5)
    best = math.nan
    for k in range(-2, 3):
        value = turn + k * math.pi
        if low <= value <= high and not abs(value) >= abs(best):
            best = value
    return best


@compiled
def _nearest_node(
    thrusters: Thrusters,
    azimuth: FloatArray,
    low: FloatArray,
    high: FloatArray,
    rate: FloatArray,
    points: int,
    nodes: IntArray,
    gains: FloatArray,
    found: FloatArray,
) -> None:
    at, turned = azimuth.copy(), azimuth.copy()
    least, greatest = math.inf, 0.0
    for node in nodes:
        _angles_of(node, points, thrusters.turning, at)
        time = 0.0
        for j in thrusters.turning:
            turn = _nearer(at[j] - azimuth[j], low[j], high[j])
            if math.isnan(turn):
                time = math.inf
                break
            turned[j] = azimuth[j] + turn
            time = max(time, abs(turn) / rate[j])
        if time < least - 1e-9 or (time < least + 1e-9 and gains[node] > greatest):
            least, greatest = time, gains[node]
            found[:] = turned


@compiled
def _bounds(
    thrusters: Thrusters, azimuth: FloatArray, points: int, nodes: IntArray, tau: FloatArray, bounds: FloatArray
) -> None:
    """Write the cost without limits of thrust: tau' (Q^-1 + B W^-1 B')^-1 tau, a lower bound."""
    turning = thrusters.turning
    base = np.zeros(6)  # xx, yy, nn, xy, xn, yn
    for a in range(3):
        base[a] = thrusters.compliance[a]
    for j in thrusters.used:
        fixed = True
        for i in turning:
            fixed = fixed and i != j
        if fixed:
            _add_outer(thrusters, j, azimuth[j], base)
    table = np.zeros((len(turning), points, 6))
    for i in range(len(turning)):
        for p in range(points):
            _add_outer(thrusters, turning[i], p * math.pi / points, table[i, p])
    x, y, n = tau[0], tau[1], tau[2]
    for k in range(len(nodes)):
        node = nodes[k]
        a, b, c, d, e, f = base[0], base[1], base[2], base[3], base[4], base[5]
        for i in range(len(turning)):
            row = table[i, node % points]
            node //= points
            a += row[0]
            b += row[1]
            c += row[2]
            d += row[3]
            e += row[4]
            f += row[5]
        # By the adjugate; the compliance keeps the determinant above zero.
        A, B, C = b * c - f * f, a * c - e * e, a * b - d * d
        D, E, F = e * f - c * d, d * f - b * e, d * e - a * f
        determinant = a * A + d * D + e * E
        value = A * x * x + B * y * y + C * n * n + 2.0 * (D * x * y + E * x * n + F * y * n)
        bounds[k] = value / determinant


@compiled
def _add_outer(thrusters: Thrusters, j: int, azimuth: float, sums: FloatArray) -> None:
    c, s = math.cos(azimuth), math.sin(azimuth)
    x = thrusters.columns[j, 0, 0] * c + thrusters.columns[j, 0, 1] * s
    y = thrusters.columns[j, 1, 0] * c + thrusters.columns[j, 1, 1] * s
    n = thrusters.columns[j, 2, 0] * c + thrusters.columns[j, 2, 1] * s
    w = 1.0 / thrusters.weight[j]
    sums[0] += w * x * x
    sums[1] += w * y * y
    sums[2] += w * n * n
    sums[3] += w * x * y
    sums[4] += w * x * n
    sums[5] += w * y * n


@compiled
def _best_node(
    thrusters: Thrusters,
    azimuth: FloatArray,
    low: FloatArray,
    high: FloatArray,
    points: int,
    nodes: IntArray,
    tau: FloatArray,
    found: FloatArray,
    best: float,
    cursor: int,
) -> tuple[float, int]:
    """Write the cheapest point if it is cheaper than ``best``; return its cost, and where to go on next time."""
    bounds = np.empty(len(nodes))
    _bounds(thrusters, azimuth, points, nodes, tau, bounds)
    # The work arrays of `_cheapest_way_round`.
    at, trial, thrust, multiplier = azimuth.copy(), azimuth.copy(), np.empty(len(azimuth)), np.zeros(3)
    for _ in range(_EVALUATIONS):
        k = -1
        least = best
        for i in range(len(nodes)):
            if bounds[i] < least:
                k, least = i, bounds[i]
        if k < 0:
            return best, cursor
        bounds[k] = math.inf
        _angles_of(nodes[k], points, thrusters.turning, at)
        best = _cheapest_way_round(
            thrusters, azimuth, low, high, tau, least, at, trial, thrust, multiplier, found, best
        )
    left = _ROLLING
    for i in range(len(nodes)):
        k = (cursor + i) % len(nodes)
        if bounds[k] < best:
            _angles_of(nodes[k], points, thrusters.turning, at)
            best = _cheapest_way_round(
                thrusters, azimuth, low, high, tau, bounds[k], at, trial, thrust, multiplier, found, best
            )
            left -= 1
            if left == 0:
                return best, k + 1
    return best, cursor


@compiled
def _cheapest_way_round(
    thrusters: Thrusters,
    azimuth: FloatArray,
    low: FloatArray,
    high: FloatArray,
    tau: FloatArray,
    bound: float,
    at: FloatArray,
    trial: FloatArray,
    thrust: FloatArray,
    multiplier: FloatArray,
    found: FloatArray,
    best: float,
) -> float:
    """Try a point with every thruster this way round and that; write the cheapest if below ``best``, return its cost.

    The nearest comes first. If it costs no more than the bound, no limit is met, and the other ones cost the same.
    """
    turning = thrusters.turning
    for flips in range(1 << len(turning)):
        allowed = True
        for i in range(len(turning)):
            j = turning[i]
            turn = _nearer(at[j] - azimuth[j], low[j], high[j])
            if (flips >> i) & 1:
                other = turn - math.pi if turn > 0.0 else turn + math.pi
                if not low[j] <= other <= high[j]:
                    other = turn + math.pi if turn > 0.0 else turn - math.pi
                turn = other if low[j] <= other <= high[j] else math.nan
            if math.isnan(turn):
                allowed = False
                break
            trial[j] = azimuth[j] + turn
        if not allowed:
            continue
        multiplier[:] = 0.0
        cost = static_cost(thrusters, trial, tau, multiplier, thrust)
        if cost < best * (1.0 - 1e-9):
            best = cost
            found[:] = trial
        if cost <= bound * (1.0 + 1e-6):
            break
    return best
