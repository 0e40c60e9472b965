"""A cross of marching thrusters: portions beside the attainable set, and thrust over speed with and without maps."""

from __future__ import annotations

import numpy as np
import pytest

from dp_tools.compare.group import groups_of
from dp_tools.compare.polytope import inside
from dp_tools.compare.portion_study import PortionStudy, cross_with_limit, study_portions
from dp_tools.compare.speed_study import DriveInWater, SpeedStudy, drives_of, study_speed
from marine_model import load_vessel
from support.marching_thruster import DENSITY, MODEL, TABLE_2, TABLE_3, drive, driven_vessel
from thrust_allocator.feasible import Portions, portion

VESSEL = driven_vessel()


@pytest.fixture(scope="module")
def portions() -> PortionStudy:
    group = groups_of(VESSEL)[0]
    found = cross_with_limit(VESSEL)
    assert found is not None
    cross, thrust_max = found
    return study_portions(cross, thrust_max, group, group.attainable(), 300, np.random.default_rng(2))


@pytest.fixture(scope="module")
def speed() -> SpeedStudy:
    (one,) = drives_of(VESSEL)
    return study_speed(*one)


def test_geometry_of_the_cross() -> None:
    found = cross_with_limit(VESSEL)
    assert found is not None
    cross, thrust_max = found
    assert np.degrees(cross.angle) == pytest.approx(22.5)
    assert (cross.stern_arm, cross.bow_arm, cross.bow_min, cross.bow_max) == pytest.approx((1.0, 0.8, -42.0, 42.0))
    assert thrust_max == 42.0
    assert cross_with_limit(load_vessel("ukwial")) is None


def test_rectangles_in_hexagons(portions: PortionStudy) -> None:
    """Hexagon 3 X N, rectangle 4 P X (1 - P) N: a third at best, in both planes.

    Corners of the hexagon: all of surge, and all of yaw with the surge of the other two thrusters, half of all.
    """
    surge, _, pitch, yaw = portions.limits
    assert portions.sections[0].volume == pytest.approx(3.0 * surge * yaw, rel=1e-9)
    assert portions.sections[1].volume == pytest.approx(3.0 * surge * pitch, rel=1e-9)
    for row in portions.rows:
        share = row.surge_portion
        assert row.area_ratios == pytest.approx([4.0 * share * (1.0 - share) / 3.0] * 2, rel=1e-9)
        assert row.limits[0] == pytest.approx(share * surge, rel=1e-9)
        assert row.limits[3] == pytest.approx((1.0 - share) * yaw, rel=1e-9)
        # All of a rectangle is attainable.
        for section, across in zip(portions.sections, (row.limits[3], row.limits[2]), strict=True):
            assert inside(section.load(np.array([row.limits[0], across])))
    assert portions.middle.surge_portion == 0.5


def test_the_corner_of_a_rectangle_is_just_met(portions: PortionStudy) -> None:
    cross = cross_with_limit(VESSEL)
    assert cross is not None
    row = portions.rows[1]
    own = Portions(0.35, 0.65, 0.65)
    for demand in ([row.limits[0], 0.0, 0.0, row.limits[3]], [row.limits[0], 0.0, row.limits[2], 0.0]):
        surge, heave, pitch, yaw = np.array(demand)
        load = portion(surge, heave, pitch, yaw, cross[0], own, 42.0).load
        assert float(load) == pytest.approx(1.0, rel=1e-9)


def test_portions_meet_only_what_is_attainable(portions: PortionStudy) -> None:
    assert all(0.0 < row.met < portions.attainable for row in portions.rows)


# Speed ---------------------------------------------------------------------------------------------------------------


def test_shortfall_at_2_m_per_s_is_that_of_table_2(speed: SpeedStudy) -> None:
    """24.8 N get code 88 by Table 3; 88 is 10.02 N at 2 m/s by Table 2."""
    k0, k1, k2, k3 = TABLE_3["ahead"]
    code = round(k0 + k1 * 24.8 + k2 * 24.8**2 + k3 * 24.8**3)
    assert code == 88
    c, b, a = (TABLE_2[name][4] for name in ("constant", "linear", "quadratic"))
    row = speed.rows[-1]
    assert row.speed == 2.0
    assert row.shortfall[0] == pytest.approx(24.8 - (c + b * code + a * code**2), rel=1e-9)
    assert row.shortfall[0] == pytest.approx(14.78, abs=0.01)
    # The equilibrium is within half a newton of Table 2.
    assert row.shortfall[1] == pytest.approx(row.shortfall[0], abs=0.5)
    # At rest there is none but for the maps' own residual.
    assert np.abs(speed.rows[0].shortfall).max() < 0.5


def test_compensation_leaves_the_residual_of_the_maps(speed: SpeedStudy) -> None:
    """Largest error of Tables 2 and 4 together with whole codes, as it comes out at 0, 0.5, ... 2 m/s."""
    assert [row.error[0] for row in speed.rows] == pytest.approx([0.757, 0.889, 0.939, 0.693, 0.843], abs=2e-3)
    assert max(row.error[1] for row in speed.rows) < 1.0
    for row in speed.rows:
        assert row.rms[0] < row.error[0]
        # T_max of Table 4 is what the largest code gives, to the residual.
        assert row.at_code_max == pytest.approx([row.thrust_max] * 2, abs=0.7)
    with_map, without_map = speed.at_top["map", True], speed.at_top["map", False]
    assert (without_map <= with_map).all()


def test_equilibrium_is_where_the_torques_meet() -> None:
    of = DriveInWater(drive(), MODEL, DENSITY)
    thrust = of.thrust(100, 1.5, "equilibrium")
    # Found another way: on a fine grid of shaft speeds the surplus of torque changes its sign where the thrust is.
    n = np.linspace(10.0, 40.0, 30001)
    given, needed = MODEL.forces(n, 1.5, DENSITY)
    surplus = np.array([of.drive.torque(100, float(speed)) for speed in n]) - needed
    at = int(np.flatnonzero(surplus <= 0.0)[0])
    assert surplus[0] > 0.0
    assert thrust == pytest.approx(float(given[at]), abs=0.01)
    assert of.thrust(0, 1.5, "equilibrium") == 0.0
    assert of.thrust(100, 0.0, "equilibrium") == pytest.approx(of.thrust(100, 0.0, "map"), rel=1e-8)


def test_thrusters_with_the_same_drive_are_one() -> None:
    found = drives_of(VESSEL)
    assert [(name, count) for name, count, _ in found] == [("upper", 5)]
    assert drives_of(load_vessel("ukwial")) == []
