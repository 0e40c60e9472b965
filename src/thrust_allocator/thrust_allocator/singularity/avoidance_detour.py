"""A way between two configurations that keeps the gain, where turning straight there does not."""

from __future__ import annotations

import itertools
import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.singularity.avoidance_route import Route
from thrust_allocator.singularity.avoidance_search import Grid
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, gain_at

_SAMPLES = 4  # of the gain between two points of the way


def find_detour(
    thrusters: Thrusters,
    grid: Grid,
    start: FloatArray,
    target: FloatArray,
    rate: FloatArray,
    threshold: float,
) -> Route | None:
    """Return the way with the fewest grid cells on which the gain stays at ``threshold``; None if the grid has none.

    It ends in ``target`` or in what differs from it by half turns, whose gain is the same: breadth-first search over
    half a turn of every thruster. Thrusters must be free to turn all round.

    Parameters
    ----------
    thrusters, grid
        The grid must be that of the thrusters.
    start, target
        Shape (n,), rad, both with sufficient gain.
    rate
        Shape (n,), rad/s.
    threshold
        Gain to keep.
    """
    turning = thrusters.turning
    cell = math.pi / grid.points
    first, into = _entry(thrusters, grid, start, threshold)
    last, out = _entry(thrusters, grid, target, threshold)
    if first < 0 or last < 0:
        return None
    moves = np.array([m for m in itertools.product((-1, 0, 1), repeat=len(turning)) if any(m)], dtype=np.int64)
    path = np.empty((len(grid.gains), len(turning)), dtype=np.int64)
    length = _breadth_first(thrusters, start, grid.points, grid.gains, threshold, moves, first, last, path)
    if length == 0:
        return None
    azimuth = np.tile(start, (length + 2, 1))
    azimuth[1:-1, turning] = start[turning] + into[turning] + cell * path[:length]
    azimuth[-1] = azimuth[-2] - out
    # Every leg is at most a cell long.
    spacing = cell / float(rate[turning].min())
    return Route(azimuth, spacing, math.nan, threshold)


def _entry(thrusters: Thrusters, grid: Grid, azimuth: FloatArray, threshold: float) -> tuple[int, FloatArray]:
    """Return a grid point about ``azimuth`` that can be reached with the gain kept, and the turn to it; -1 if none."""
    turning, points = thrusters.turning, grid.points
    cell = math.pi / points
    base = np.floor(azimuth[turning] / cell)
    corners = []
    for corner in itertools.product((0, 1), repeat=len(turning)):
        turn = np.zeros(len(azimuth))
        at = base + corner
        turn[turning] = at * cell - azimuth[turning]
        node = int(sum((int(k) % points) * points**i for i, k in enumerate(at)))
        corners.append((-float(grid.gains[node]), node, turn))
    for gain, node, turn in sorted(corners, key=lambda corner: corner[0]):
        if -gain >= threshold and _open(thrusters, azimuth, turn, threshold):
            return node, turn
    return -1, np.zeros(len(azimuth))


@compiled
def _open(thrusters: Thrusters, azimuth: FloatArray, turn: FloatArray, threshold: float) -> bool:
    at, unused = azimuth.copy(), np.empty(3)
    for k in range(1, _SAMPLES):
        for j in range(len(at)):
            at[j] = azimuth[j] + turn[j] * k / _SAMPLES
        if gain_at(thrusters, at, unused) < threshold:
            return False
    return True


@compiled
def _breadth_first(
    thrusters: Thrusters,
    start: FloatArray,
    points: int,
    gains: FloatArray,
    threshold: float,
    moves: IntArray,
    first: int,
    last: int,
    path: IntArray,
) -> int:
    """Write the turns of the way in cells from its first point, (length, r); return its length, 0 if there is none."""
    turning = thrusters.turning
    r = len(turning)
    cell = math.pi / points
    by = np.full(len(gains), -2, dtype=np.int64)  # move that led there
    previous = np.full(len(gains), -1, dtype=np.int64)
    queue = np.empty(len(gains), dtype=np.int64)
    at, turn = start.copy(), np.zeros(len(start))
    queue[0], by[first] = first, -1
    head, tail = 0, 1
    while head < tail and by[last] == -2:
        node = queue[head]
        head += 1
        for m in range(len(moves)):
            to, rest, stride = 0, node, 1
            for i in range(r):
                k = rest % points
                rest //= points
                at[turning[i]] = k * cell
                turn[turning[i]] = moves[m, i] * cell
                to += ((k + moves[m, i]) % points) * stride
                stride *= points
            if by[to] != -2 or gains[to] < threshold or not _open(thrusters, at, turn, threshold):
                continue
            by[to], previous[to] = m, node
            queue[tail] = to
            tail += 1
    if by[last] == -2:
        return 0
    length, node = 1, last
    while node != first:
        length += 1
        node = previous[node]
    node = last
    for k in range(length - 1, 0, -1):
        for i in range(r):
            path[k, i] = moves[by[node], i]
        node = previous[node]
    for i in range(r):
        path[0, i] = 0
    for k in range(1, length):
        for i in range(r):
            path[k, i] += path[k - 1, i]
    return length
