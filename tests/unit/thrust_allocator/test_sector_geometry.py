"""Sectors to windows: [Ruth] Table 6.1, and the properties that any set of sectors must give."""

from __future__ import annotations

import math

import pytest
from hypothesis import given

from marine_model import load_vessel
from marine_model.frames import wrap_angle
from marine_model.sector import Sector
from support.sector_cases import CIRCLE, HALF_DEGREE, Circle, circles
from thrust_allocator.sectors import Window, combinations, factor_at, thruster_sectors, vessel_sectors

# Table 6.1: alpha_2, alpha_3, alpha_4 of sub-problems 1 to 18, deg.
TABLE_6_1 = [
    ((30, 209), (-70, 109), (-109, 70)),
    ((30, 209), (-70, 109), (-159, 20)),
    ((30, 209), (-70, 109), (110, 150)),
    ((30, 209), (-20, 159), (-109, 70)),
    ((30, 209), (-20, 159), (-159, 20)),
    ((30, 209), (-20, 159), (110, 150)),
    ((30, 209), (-150, -110), (-109, 70)),
    ((30, 209), (-150, -110), (-159, 20)),
    ((30, 209), (-150, -110), (110, 150)),
    ((-209, -30), (-70, 109), (-109, 70)),
    ((-209, -30), (-70, 109), (-159, 20)),
    ((-209, -30), (-70, 109), (110, 150)),
    ((-209, -30), (-20, 159), (-109, 70)),
    ((-209, -30), (-20, 159), (-159, 20)),
    ((-209, -30), (-20, 159), (110, 150)),
    ((-209, -30), (-150, -110), (-109, 70)),
    ((-209, -30), (-150, -110), (-159, 20)),
    ((-209, -30), (-150, -110), (110, 150)),
]


def degrees(window: Window) -> tuple[float, float]:
    return round(math.degrees(window.start), 9), round(math.degrees(window.end), 9)


def holds(window: Window, angle: float) -> bool:
    return abs(wrap_angle(angle - window.centre)) <= window.half_width + 1e-9  # rounding of degrees


@pytest.mark.parametrize("name", ["cybership3", "cybership3_ch7"])
def test_table_6_1(name: str) -> None:
    thrusters = vessel_sectors(load_vessel(name))
    found = [
        tuple(degrees(thrusters[j].windows[row[j]]) for j in (1, 2, 3)) for row in combinations(thrusters) if not row[0]
    ]
    assert found == TABLE_6_1
    assert len(list(combinations(thrusters))) == 18  # the tunnel thruster has one window


def test_without_sectors_the_whole_circle_is_a_disc() -> None:
    (window,) = thruster_sectors([]).windows
    assert window.disc
    assert (window.half_width, window.thrust_factor) == (math.pi, 1.0)
    whole = Sector(start=-math.pi, end=math.pi, kind="reduced", thrust_factor=0.4)
    reduced = thruster_sectors([whole])
    assert reduced.windows[0].disc
    assert reduced.windows[0].thrust_factor == 0.4
    assert {factor_at(reduced, angle) for angle in (-math.pi, -1.0, 0.0, 3.0)} == {0.4}


@pytest.mark.parametrize(
    ("width", "count"), [(1, 1), (179, 1), (180, 2), (181, 2), (229, 2), (300, 2), (350, 2), (351, 3), (359, 3)]
)
def test_number_of_windows(width: int, count: int) -> None:
    circle = Circle(((0, width, "plain", 1.0), (width, 360 - width, "forbidden", 1.0)))
    windows = thruster_sectors(circle.sectors).windows
    assert len(windows) == count
    if count > 1:
        assert {round(2 * math.degrees(window.half_width), 9) for window in windows} == {179.0}


def test_a_reduced_sector_is_a_window_of_its_own() -> None:
    circle = Circle(((-90, 60, "reduced", 0.5), (-30, 20, "forbidden", 0.8)))
    thruster = thruster_sectors(circle.sectors)
    assert sorted((*degrees(w), w.thrust_factor) for w in thruster.windows) == [
        (-269.0, -90.0, 1.0),  # with the last one, of [-10, 270] deg
        (-90.0, -30.0, 0.5),
        (-10.0, 169.0, 1.0),
    ]


@given(circles())
def test_windows_cover_exactly_what_is_allowed(circle: Circle) -> None:
    windows = thruster_sectors(circle.sectors).windows
    cells = circle.cells()
    for k in range(CIRCLE):
        covering = [window for window in windows if holds(window, (k + 0.5) * HALF_DEGREE)]
        kind, factor = cells[k]
        assert bool(covering) == (kind != "forbidden")
        assert all(window.thrust_factor == factor for window in covering)
        # An end belongs to what is allowed beside it.
        at_end = any(holds(window, k * HALF_DEGREE) for window in windows)
        assert at_end == (kind != "forbidden" or cells[k - 1][0] != "forbidden")


@given(circles())
def test_windows_are_convex_and_neighbours_overlap(circle: Circle) -> None:
    thruster = thruster_sectors(circle.sectors)
    for window in thruster.windows:
        assert window.disc or window.end - window.start < math.pi
        assert window.start == pytest.approx(window.centre - window.half_width, abs=1e-12)
        assert window.end == pytest.approx(window.centre + window.half_width, abs=1e-12)
        assert -math.pi <= window.centre < math.pi
    if len(circle.sectors) == 0:
        return
    # Going round, a window begins inside the one before, or at the end of a sector.
    ends = [angle for sector in circle.sectors for angle in (sector.start, sector.end)]
    for window in thruster.windows:
        if not window.disc and min(abs(wrap_angle(window.start - end)) for end in ends) > 1e-9:
            overlaps = [wrap_angle(other.end - window.start) for other in thruster.windows if other != window]
            assert max(overlaps) > math.radians(7.9)


@given(circles())
def test_order(circle: Circle) -> None:
    keys = [(round(abs(w.centre), 9), w.centre < 0.0) for w in thruster_sectors(circle.sectors).windows]
    assert keys == sorted(keys)


@given(circles())
def test_port_and_starboard_are_alike(circle: Circle) -> None:
    def shape(window: Window, sign: float) -> tuple[float, float, float, float, bool]:
        # Sine and cosine, since a centre at -180 deg is its own mirror image; plus zero makes -0.0 equal in order too.
        east, ahead = round(sign * math.sin(window.centre), 9) + 0.0, round(math.cos(window.centre), 9)
        return ahead, east, round(window.half_width, 9), window.thrust_factor, window.disc

    here, there = thruster_sectors(circle.sectors), thruster_sectors(circle.mirrored().sectors)
    assert sorted(shape(w, 1.0) for w in here.windows) == sorted(shape(w, -1.0) for w in there.windows)


@given(circles())
def test_thrust_factor(circle: Circle) -> None:
    thruster = thruster_sectors(circle.sectors)
    cells = circle.cells()
    for k in range(CIRCLE):
        assert factor_at(thruster, (k + 0.5) * HALF_DEGREE) == cells[k][1]


def test_at_the_end_of_a_sector_thrust_is_full() -> None:
    circle = Circle(((30, 60, "forbidden", 0.5), (120, 30, "reduced", 0.2)))
    thruster = thruster_sectors(circle.sectors)
    assert [factor_at(thruster, math.radians(a)) for a in (30, 31, 89, 90, 120, 121, 150)] == [
        1,
        0.5,
        0.5,
        1,
        1,
        0.2,
        1,
    ]


def test_cybership3_may_reverse_in_its_fixed_directions() -> None:
    vessel = load_vessel("cybership3")
    for thruster, fixed in zip(vessel_sectors(vessel), vessel.fixed_direction, strict=True):
        for direction in (fixed, fixed + math.pi):
            assert any(holds(window, direction) for window in thruster.windows)
