"""From the sectors of a thruster to the convex windows it may point in: [Ruth] 6.4.1, Figure 6.2, Table 6.1."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from marine_model.sector import ANGLE_TOLERANCE, Sector

_TWO_PI = 2.0 * math.pi
# A cone is convex below 180 deg. What is wider is cut into windows of 179 deg, as in Table 6.1.
WINDOW_WIDTH = math.radians(179.0)
# Two windows serve an interval of up to 350 deg: with any overlap a thruster that has come to the end of one window
# lies in the next already.
LEAST_OVERLAP = math.radians(8.0)


class Window(NamedTuple):
    """Directions that are searched together, ``start`` to ``end`` with increasing azimuth, both included.

    Attributes
    ----------
    start, end
        rad; ``centre`` lies in [-pi, pi), so that either end may lie beyond pi.
    centre, half_width
        rad; the same once more, in the form that tests whether an angle is inside.
    thrust_factor
        Share of the largest thrust that may be used in this window.
    disc
        The whole circle: a disc is convex without a cone. ``start`` and ``end`` are no limits then.
    """

    start: float
    end: float
    centre: float
    half_width: float
    thrust_factor: float
    disc: bool


class Arc(NamedTuple):
    """A forbidden or reduced sector: centre and half of its width (rad), share of the thrust that is left in it."""

    centre: float
    half_width: float
    thrust_factor: float


@dataclass(frozen=True, slots=True)
class ThrusterSectors:
    """Sectors of one thruster, ready to be searched.

    Attributes
    ----------
    windows
        By rising ``abs(centre)``, the positive one first of two that are equal. A thruster without sectors has one,
        the whole circle.
    forbidden
        Where the thruster must not stay.
    limited
        Forbidden and reduced sectors in which less than the full thrust may be given.
    """

    windows: tuple[Window, ...]
    forbidden: tuple[Arc, ...]
    limited: tuple[Arc, ...]


class _Interval(NamedTuple):
    start: float
    width: float
    thrust_factor: float


def thruster_sectors(sectors: Sequence[Sector]) -> ThrusterSectors:
    """Return windows and arcs of a thruster that has these sectors.

    Raises
    ------
    InputError
        If no direction is left.
    """
    windows = [window for interval in _allowed(sectors) for window in _cut(interval)]
    if not windows:
        raise InputError("sectors: expected at least one direction that is allowed, found none")
    # Rounding must not decide on the order of two windows that mirror each other.
    windows.sort(key=lambda window: (round(abs(window.centre), 9), window.centre < 0.0))
    forbidden = [sector for sector in sectors if sector.kind == "forbidden"]
    limited = [sector for sector in sectors if sector.thrust_factor < 1.0]
    return ThrusterSectors(tuple(windows), tuple(map(_arc, forbidden)), tuple(map(_arc, limited)))


def vessel_sectors(vessel: Vessel) -> tuple[ThrusterSectors, ...]:
    """Return :func:`thruster_sectors` of every thruster; a tunnel thruster has the whole circle, it cannot use it."""
    return tuple(thruster_sectors(sectors) for sectors in vessel.sectors)


def combinations(thrusters: Sequence[ThrusterSectors]) -> Iterator[tuple[int, ...]]:
    """Yield one window index a thruster, the last thruster fastest: the sub-problems in the order of Table 6.1."""
    return itertools.product(*(range(len(thruster.windows)) for thruster in thrusters))


def factor_at(thruster: ThrusterSectors, azimuth: float) -> float:
    """Return the share of the largest thrust that may be given at ``azimuth`` (rad).

    The end of a sector belongs to the directions beside it, where the full thrust is allowed.
    """
    for arc in thruster.limited:
        inside = abs(wrap_angle(azimuth - arc.centre)) < arc.half_width - ANGLE_TOLERANCE
        if inside or arc.half_width > math.pi - ANGLE_TOLERANCE:  # a whole circle has no ends
            return arc.thrust_factor
    return 1.0


def least_factor(thruster: ThrusterSectors, azimuth: float, turn: float) -> float:
    """Return the least share of the largest thrust that may be given on the way from ``azimuth`` by ``turn``, rad."""
    least = factor_at(thruster, azimuth)
    half = 0.5 * abs(turn)
    for arc in thruster.limited:
        if abs(wrap_angle(azimuth + 0.5 * turn - arc.centre)) < arc.half_width + half - ANGLE_TOLERANCE:
            least = min(least, arc.thrust_factor)
    return least


def _arc(sector: Sector) -> Arc:
    half_width = 0.5 * sector.width
    return Arc(wrap_angle(sector.start + half_width), half_width, sector.thrust_factor)


def _allowed(sectors: Sequence[Sector]) -> list[_Interval]:
    """Return reduced sectors, and what lies between one sector and the next."""
    if not sectors:
        return [_Interval(-math.pi, _TWO_PI, 1.0)]
    found = [
        _Interval(sector.start, sector.width, sector.thrust_factor) for sector in sectors if sector.kind == "reduced"
    ]
    ordered = sorted(sectors, key=lambda sector: sector.start % _TWO_PI)
    for sector, following in zip(ordered, [*ordered[1:], ordered[0]], strict=True):
        gap = (following.start - sector.end) % _TWO_PI
        # Two that touch leave nothing, or all but nothing of a whole turn where rounding has put one on the other.
        if ANGLE_TOLERANCE < gap < _TWO_PI - ANGLE_TOLERANCE:
            found.append(_Interval(sector.end, gap, 1.0))
    return found


def _cut(interval: _Interval) -> list[Window]:
    """Return the interval itself if it is convex, else equally wide windows from one end of it to the other."""
    start, width, factor = interval
    if width > _TWO_PI - ANGLE_TOLERANCE:
        return [Window(-math.pi, math.pi, 0.0, math.pi, factor, disc=True)]
    if width < math.pi - ANGLE_TOLERANCE:
        return [_window(start, width, factor)]
    rest = width - WINDOW_WIDTH
    further = math.ceil(rest / (WINDOW_WIDTH - LEAST_OVERLAP) - ANGLE_TOLERANCE)
    return [_window(start + k * rest / further, WINDOW_WIDTH, factor) for k in range(further + 1)]


def _window(start: float, width: float, thrust_factor: float) -> Window:
    middle = start + 0.5 * width
    centre = wrap_angle(middle)
    turned = centre - middle  # whole turns
    return Window(start + turned, start + width + turned, centre, 0.5 * width, thrust_factor, disc=False)
