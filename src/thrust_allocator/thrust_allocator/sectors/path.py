"""The way of a thruster from where it points into a window: how far, and whether through a forbidden sector."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from marine_model.compiled import compiled
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.sector import ANGLE_TOLERANCE
from thrust_allocator.plan.phase import Limit
from thrust_allocator.sectors.geometry import ThrusterSectors

IntArray = NDArray[np.int64]

_PI = float(np.pi)
_TWO_PI = 2.0 * _PI
_TOLERANCE = ANGLE_TOLERANCE
_REACH_LOW, _REACH_HIGH, _TO_WINDOW = Limit.REACH_LOW, Limit.REACH_HIGH, Limit.TO_WINDOW


class Reach(IntEnum):
    """What lies between where a thruster points and a window of it; of a combination, the largest of its thrusters."""

    FREE = 0  # nothing: it lies in the window, or the window is the one chosen already
    TURN = 1  # allowed directions
    CROSS = 2  # a forbidden sector


class Path(NamedTuple):
    """``turn`` (rad, positive with increasing azimuth, 0 when inside) brings the thruster to the window's nearest end.

    ``crosses``: a forbidden sector, or the rest of one, lies on the way.
    """

    inside: bool
    turn: float
    crosses: bool


class SectorTable(NamedTuple):
    """Windows and forbidden sectors of all thrusters as flat arrays, for machine code.

    Row m of ``windows`` and ``forbidden`` is (centre, half width), rad. Thruster j has the rows ``first_window[j]`` to
    ``first_window[j + 1] - 1``, and those of ``first_forbidden`` likewise.
    """

    windows: FloatArray  # (M, 2)
    first_window: IntArray  # (n + 1,)
    forbidden: FloatArray  # (K, 2)
    first_forbidden: IntArray  # (n + 1,)


def sector_table(thrusters: Sequence[ThrusterSectors]) -> SectorTable:
    """Return the flat form of ``thrusters``."""

    def flat(rows: list[list[tuple[float, float]]]) -> tuple[FloatArray, IntArray]:
        first = np.cumsum([0, *map(len, rows)], dtype=np.int64)
        return np.array([pair for row in rows for pair in row], dtype=np.float64).reshape(-1, 2), first

    windows, first_window = flat([[(w.centre, w.half_width) for w in t.windows] for t in thrusters])
    forbidden, first_forbidden = flat([[(a.centre, a.half_width) for a in t.forbidden] for t in thrusters])
    return SectorTable(windows, first_window, forbidden, first_forbidden)


@compiled
def wrapped(angle: float) -> float:
    """Return ``angle`` (rad) plus whole turns, in [-pi, pi] up to rounding."""
    return angle - _TWO_PI * np.floor((angle + _PI) / _TWO_PI)  # type: ignore[no-any-return]


@compiled
def _crosses(azimuth: float, turn: float, forbidden: FloatArray, first: int, last: int) -> bool:
    """Return whether the turn has more than an end in common with a forbidden sector of the rows first to last - 1."""
    half = 0.5 * abs(turn)
    middle = azimuth + 0.5 * turn
    crossing = False
    for k in range(first, last):
        crossing |= abs(wrapped(forbidden[k, 0] - middle)) < forbidden[k, 1] + half - _TOLERANCE
    return crossing


@compiled
def path_into(
    azimuth: float, centre: float, half_width: float, forbidden: FloatArray, first: int, last: int
) -> tuple[bool, float, bool]:
    """Return ``inside``, ``turn`` and ``crosses`` of :class:`Path`, for machine code.

    The shorter way round is taken. Of two of one length it is the one that crosses no forbidden sector; if that does
    not decide, the one with increasing azimuth.

    Parameters
    ----------
    azimuth
        Where the thruster points, rad.
    centre, half_width
        The window, rad.
    forbidden, first, last
        Rows ``first`` to ``last - 1`` of a :class:`SectorTable`.
    """
    offset = wrapped(azimuth - centre)
    if abs(offset) <= half_width + _TOLERANCE:
        return True, 0.0, False
    short = abs(offset) - half_width
    long = _TWO_PI - half_width - abs(offset)
    if long - short > _TOLERANCE:
        turn = short if offset < 0.0 else -short
        return False, turn, _crosses(azimuth, turn, forbidden, first, last)
    if not _crosses(azimuth, short, forbidden, first, last):
        return False, short, False
    return False, -short, _crosses(azimuth, -short, forbidden, first, last)


@compiled
def reach_table(
    azimuth: FloatArray,
    chosen: IntArray,
    windows: FloatArray,
    first_window: IntArray,
    forbidden: FloatArray,
    first_forbidden: IntArray,
) -> IntArray:
    """Return the :class:`Reach` of every window of every thruster, shape (M,), by the rows of :class:`SectorTable`.

    The chosen window of a thruster is always free: nothing has to be decided to go on.

    Parameters
    ----------
    azimuth
        Where the thrusters point, rad, shape (n,).
    chosen
        Index of the chosen window of each thruster, shape (n,).
    windows, first_window, forbidden, first_forbidden
        ``*table`` of a :class:`SectorTable`.
    """
    reach = np.zeros(windows.shape[0], dtype=np.int64)
    for j in range(azimuth.shape[0]):
        first, last = first_forbidden[j], first_forbidden[j + 1]
        for m in range(first_window[j], first_window[j + 1]):
            if m - first_window[j] == chosen[j]:
                continue
            inside, _, crosses = path_into(azimuth[j], windows[m, 0], windows[m, 1], forbidden, first, last)
            if crosses:
                reach[m] = 2  # Reach.CROSS
            elif not inside:
                reach[m] = 1  # Reach.TURN
    return reach


@compiled
def narrow(
    limits: FloatArray,
    azimuth: FloatArray,
    chosen: IntArray,
    limited: IntArray,
    windows: FloatArray,
    first_window: IntArray,
    forbidden: FloatArray,
    first_forbidden: IntArray,
) -> int:
    """Write what the chosen windows leave to every thruster into ``limits``; return how many are outside theirs.

    Parameters
    ----------
    limits
        Table of limits, shape (n, 14), see :class:`phase.Limit`: ``REACH_LOW``, ``REACH_HIGH`` and ``TO_WINDOW``.
    azimuth, chosen
        Shape (n,), rad, and index of the window.
    limited
        Shape (n,): 0 for thrusters that no window limits.
    windows, first_window, forbidden, first_forbidden
        ``*table`` of a :class:`SectorTable`.
    """
    outside = 0
    for j in range(azimuth.shape[0]):
        low, high, turn = -np.inf, np.inf, 0.0
        if limited[j] != 0:
            m = first_window[j] + chosen[j]
            centre, half_width = windows[m, 0], windows[m, 1]
            _, turn, _ = path_into(
                azimuth[j], centre, half_width, forbidden, first_forbidden[j], first_forbidden[j + 1]
            )
            offset = wrapped(azimuth[j] - centre)
            low, high = -half_width - offset, half_width - offset
            outside += turn != 0.0
        limits[j, _REACH_LOW] = low
        limits[j, _REACH_HIGH] = high
        limits[j, _TO_WINDOW] = turn
    return outside


def path_to(thruster: ThrusterSectors, window: int, azimuth: float) -> Path:
    """Return the way from ``azimuth`` (rad) into the window of this index.

    For tests, tools and single questions; a step asks :func:`reach_table` and :func:`path_into`.
    """
    table = sector_table([thruster])
    centre, half_width = table.windows[window]
    found: Any = path_into(azimuth, centre, half_width, table.forbidden, 0, len(table.forbidden))
    return Path(*found)


def nearest_window(thruster: ThrusterSectors, azimuth: float, preferred: int = 0) -> int:
    """Return the window for a thruster that begins to rotate at ``azimuth`` (rad).

    It is ``preferred`` (such as the one it had before) if the thruster points into it, else the one it lies deepest
    in, else the one that takes the least turn.
    """
    beyond = [abs(wrap_angle(azimuth - window.centre)) - window.half_width for window in thruster.windows]
    if beyond[preferred] <= ANGLE_TOLERANCE:
        return preferred
    return beyond.index(min(beyond))
