"""What a thruster may give in the long run in each of its windows, as convex polygons: the sub-problems of Table 6.1.

Rates play no part: whether another combination of windows is worth a turn does not depend on where the thrusters
happen to be. [Ruth] 6.4.1 lets every sub-problem go on from its own answer of the step before instead, so that 18
allocators run side by side; what they settle on is what is solved here at once.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import Limit
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.sectors.geometry import ThrusterSectors, Window

# The arc of largest thrust is cut by chords of at most this width: 0.9 % of the thrust at their middle.
_CHORD = math.radians(15.0)
# Corners of the largest polygon: a disc.
_DISC = math.ceil(2.0 * math.pi / _CHORD)


class Pieces:
    """Polygons of all windows of all thrusters.

    Attributes
    ----------
    corners, count
        Shapes (M, c, 2), N, body frame, and (M,): a row a window, in the order of ``sector_table``. No corner for a
        lost thruster, two for one that does not rotate.
    first
        Shape (n + 1,): thruster j has the rows ``first[j]`` to ``first[j + 1] - 1``.

    Parameters
    ----------
    thrusters
        Windows of every thruster.
    """

    def __init__(self, thrusters: tuple[ThrusterSectors, ...]) -> None:
        self._thrusters = thrusters
        self.first: IntArray = np.cumsum([0, *(len(thruster.windows) for thruster in thrusters)], dtype=np.int64)
        total = int(self.first[-1])
        self.corners = np.zeros((total, _DISC, 2))
        self.count: IntArray = np.zeros(total, dtype=np.int64)

    def limit(self, limits: FloatArray) -> None:
        """Take the thrust limits from the table of limits, shape (n, 14), for thrusters that rotate."""
        for j, thruster in enumerate(self._thrusters):
            for i, window in enumerate(thruster.windows):
                row = int(self.first[j]) + i
                if limits[j, Limit.ENABLED] == 0.0:
                    self.count[row] = 0
                    continue
                corners = _cone(window, window.thrust_factor * float(limits[j, Limit.THRUST_MAX]))
                self.corners[row, : len(corners)] = corners
                self.count[row] = len(corners)

    def hold(self, j: int, limits: FloatArray, azimuth: float, factor: float) -> None:
        """Let thruster ``j`` give no more than thrust along ``azimuth`` (rad), either way; ``factor`` of it ahead."""
        row = int(self.first[j])
        along = np.array((math.cos(azimuth), math.sin(azimuth)))
        self.corners[row, 0] = limits[j, Limit.THRUST_MIN] * along
        self.corners[row, 1] = factor * limits[j, Limit.THRUST_MAX] * along
        self.count[row] = 0 if limits[j, Limit.ENABLED] == 0.0 else 2


def _cone(window: Window, radius: float) -> FloatArray:
    """Return the corners of a sector of a disc, with rising angle."""
    if radius <= 0.0:
        return np.zeros((1, 2))
    if window.disc:
        angles = np.linspace(-math.pi, math.pi, _DISC, endpoint=False)
        return radius * np.column_stack((np.cos(angles), np.sin(angles)))
    chords = max(1, math.ceil(2.0 * window.half_width / _CHORD - 1e-9))
    angles = np.linspace(window.start, window.end, chords + 1)
    return np.vstack((np.zeros((1, 2)), radius * np.column_stack((np.cos(angles), np.sin(angles)))))
