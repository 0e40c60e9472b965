"""Ways into a window: hand-worked on CyberShip III, and against walking round in half degrees."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.frames import wrap_angle
from support.sector_cases import CIRCLE, HALF_DEGREE, Circle, circles
from thrust_allocator.sectors import (
    Reach,
    ThrusterSectors,
    nearest_window,
    path_to,
    reach_table,
    sector_table,
    thruster_sectors,
    vessel_sectors,
)

BOW, PORT, STARBOARD = vessel_sectors(load_vessel("cybership3"))[1:]


@pytest.mark.parametrize(
    ("thruster", "window", "azimuth", "turn", "crosses"),
    [
        (PORT, 0, 45, 0, False),  # [-70, 109]
        (PORT, 0, -70, 0, False),
        (PORT, 1, -60, 40, False),  # to -20 of [-20, 159]
        (PORT, 0, 150, -41, False),
        (PORT, 0, 159, -50, False),  # from the end of a forbidden sector, away from it
        (STARBOARD, 0, -159, 50, False),
        (PORT, 2, -70, -40, True),  # to -110 of [-150, -110], through [-110, -70]
        (PORT, 2, 159, 51, True),  # to 210, through [159, 210]
        (PORT, 0, -110, 40, True),
        (PORT, 1, -150, -51, True),
        (PORT, 2, -90, -20, True),  # from inside a forbidden sector, the rest of it
        (PORT, 0, -85, 15, True),
        (BOW, 0, -45, 75, True),  # to 30 of [30, 209], ahead
        (BOW, 1, 45, -75, True),
        (BOW, 0, -140, -11, False),  # to 209 = -151, astern
        (BOW, 1, 140, 11, False),
        (STARBOARD, 2, 20, 90, True),  # to 110 of [110, 150], through [70, 110]
        (STARBOARD, 2, -159, -51, True),
    ],
)
def test_cybership3(thruster: ThrusterSectors, window: int, azimuth: float, turn: float, crosses: bool) -> None:
    found = path_to(thruster, window, math.radians(azimuth))
    assert math.degrees(found.turn) == pytest.approx(turn, abs=1e-9)
    assert found.crosses is crosses
    assert found.inside is (turn == 0)


def test_of_two_ways_of_one_length_the_allowed_one() -> None:
    # Window [-10, 10]; from 180 deg it is 170 deg either way, with a forbidden sector on one side only.
    for side, turn in ((1, 170), (-1, -170)):
        arcs = ((-10, 20, "reduced", 0.5), (40 if side > 0 else -60, 20, "forbidden", 1.0))
        thruster = thruster_sectors(Circle(arcs).sectors)
        index = next(k for k, window in enumerate(thruster.windows) if window.thrust_factor == 0.5)
        for azimuth in (-math.pi, math.pi):
            found = path_to(thruster, index, azimuth)
            assert math.degrees(found.turn) == pytest.approx(turn)
            assert not found.crosses
    both = ((-10, 20, "reduced", 0.5), (40, 20, "forbidden", 1.0), (-60, 20, "forbidden", 1.0))
    thruster = thruster_sectors(Circle(both).sectors)
    index = next(k for k, window in enumerate(thruster.windows) if window.thrust_factor == 0.5)
    assert path_to(thruster, index, math.pi).crosses


@given(circles(), st.integers(0, CIRCLE - 1))
def test_like_walking_round(circle: Circle, at: int) -> None:
    thruster = thruster_sectors(circle.sectors)
    cells = circle.cells()
    azimuth = at * HALF_DEGREE

    def walk(window_index: int, way: int) -> tuple[int, bool]:
        """Half degrees until inside, and whether a forbidden cell was walked through."""
        window = thruster.windows[window_index]
        crossed = False
        for k in range(CIRCLE):
            if (
                window.disc
                or abs(wrap_angle(azimuth + way * k * HALF_DEGREE - window.centre)) < window.half_width + 1e-9
            ):
                return k, crossed
            crossed |= cells[(at + way * k - (way < 0)) % CIRCLE][0] == "forbidden"
        raise AssertionError("never arrived")

    for index in range(len(thruster.windows)):
        found = path_to(thruster, index, azimuth)
        (up, up_crosses), (down, down_crosses) = walk(index, 1), walk(index, -1)
        assert found.inside == (up == 0)
        assert abs(found.turn) == pytest.approx(min(up, down) * HALF_DEGREE, abs=1e-9)
        assert abs(found.turn) <= math.pi
        if up < down or (up == down and not up_crosses):
            assert (found.turn >= 0, found.crosses) == (True, up_crosses)
        elif up > down:
            assert (found.turn < 0, found.crosses) == (True, down_crosses)
        else:
            assert (found.turn < 0, found.crosses) == (True, down_crosses)
        # The turn ends in the window.
        window = thruster.windows[index]
        assert abs(wrap_angle(azimuth + found.turn - window.centre)) <= window.half_width + 1e-9


@given(circles(), st.integers(0, CIRCLE - 1))
def test_the_mirror_image_turns_the_other_way(circle: Circle, at: int) -> None:
    here, there = thruster_sectors(circle.sectors), thruster_sectors(circle.mirrored().sectors)

    def ways(thruster: ThrusterSectors, azimuth: float, sign: int) -> list[tuple[float, ...]]:
        found = []
        for index, window in enumerate(thruster.windows):
            way = path_to(thruster, index, azimuth)
            if window.half_width + abs(way.turn) > math.pi - 1e-9 and not way.inside:
                continue  # two ways of one length: increasing azimuth is no rule that a mirror keeps
            place = round(math.cos(window.centre), 9), round(sign * math.sin(window.centre), 9) + 0.0
            found.append((*place, round(window.half_width, 9), round(sign * way.turn, 9) + 0.0, way.crosses))
        return sorted(found)

    assert ways(here, at * HALF_DEGREE, 1) == ways(there, -at * HALF_DEGREE, -1)


@given(st.lists(st.tuples(circles(), st.floats(-math.pi, math.pi), st.integers(0, 20)), min_size=1, max_size=5))
def test_reach_table_is_the_paths(cases: list[tuple[Circle, float, int]]) -> None:
    thrusters = [thruster_sectors(circle.sectors) for circle, _, _ in cases]
    azimuth = np.array([azimuth for _, azimuth, _ in cases])
    chosen = np.array([pick % len(t.windows) for t, (_, _, pick) in zip(thrusters, cases, strict=True)])
    table = sector_table(thrusters)
    found = reach_table(azimuth, chosen, *table)
    expected = []
    for j, thruster in enumerate(thrusters):
        for k in range(len(thruster.windows)):
            way = path_to(thruster, k, azimuth[j])
            reach = Reach.CROSS if way.crosses else Reach.FREE if way.inside else Reach.TURN
            expected.append(Reach.FREE if k == chosen[j] else reach)
    assert found.tolist() == expected
    assert table.first_window[-1] == len(expected)


def test_a_thruster_without_sectors_is_always_inside() -> None:
    free = thruster_sectors([])
    for azimuth in (-math.pi, -1.0, 0.0, 3.1, math.pi, 7.0):
        assert path_to(free, 0, azimuth) == (True, 0.0, False)
        assert nearest_window(free, azimuth) == 0


@pytest.mark.parametrize(
    ("azimuth", "preferred", "expected"),
    [
        (45, 0, 0),  # in both wide windows: the one before is kept
        (45, 1, 1),
        (-60, 1, 0),
        (30, 2, 0),  # 11 deg nearer to the middle of [-70, 109] than of [-20, 159]
        (60, 2, 1),
        (-100, 0, 2),  # forbidden: 10 deg to [-150, -110], 30 deg to [-70, 109]
        (-75, 2, 0),
    ],
)
def test_nearest_window(azimuth: float, preferred: int, expected: int) -> None:
    assert nearest_window(PORT, math.radians(azimuth), preferred) == expected
