"""The asteroid beside what four azimuth propellers can give, at a common angle and each at its own."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest

from dp_tools.compare.azimuth_sets import apart, area_of, best_together, load_together, outline_together
from dp_tools.compare.azimuth_study import AzimuthStudy, square_of, study_azimuth
from dp_tools.compare.polytope import zonotope
from marine_model import load_vessel
from thrust_allocator.attainable import scale_to_boundary
from thrust_allocator.feasible import AzimuthSquare
from thrust_allocator.feasible.garus_azimuth import asteroid_area

VESSEL = load_vessel("ukwial_azimuth")
MOMENT = 50.0
RAYS = np.random.default_rng(6).normal(size=(40, 2)) * 300.0


def square() -> AzimuthSquare:
    found = square_of(VESSEL)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def study() -> AzimuthStudy:
    return study_azimuth(square(), 400, np.random.default_rng(1))


@pytest.mark.parametrize("degrees", [2.0, 29.1, 45.0, 80.0])
def test_at_one_angle_it_is_a_section_of_a_zonotope(degrees: float) -> None:
    """Closed form of the sums of pairs against the hull of the corners of the box of thrusts, either moment."""
    four = square()
    azimuth = four.directions(radians(degrees))
    own = list(four.thrusters)
    x, y = VESSEL.lever_x[own], VESSEL.lever_y[own]
    columns = np.array([np.cos(azimuth), np.sin(azimuth), x * np.sin(azimuth) - y * np.cos(azimuth)])
    body = zonotope(columns, np.full(4, -250.0), np.full(4, 250.0))
    loads = load_together(four, MOMENT, RAYS[:, 0], RAYS[:, 1], radians(degrees))
    for ray, load in zip(RAYS, loads, strict=True):
        for moment in (MOMENT, -MOMENT):
            share = body.share_from(np.array([0.0, 0.0, moment]), np.array([*ray, 0.0]))
            assert 1.0 / share == pytest.approx(load, rel=1e-9)


def test_the_best_angle_beats_a_fine_grid() -> None:
    surge, sway = RAYS.T
    loads, angles = best_together(square(), MOMENT, surge, sway)
    for angle in np.linspace(0.001, pi / 2.0 - 0.001, 400):
        assert (loads <= load_together(square(), MOMENT, surge, sway, angle) * (1.0 + 1e-6)).all()
    np.testing.assert_allclose(load_together(square(), MOMENT, surge, sway, angles), loads, rtol=1e-12)


def test_without_a_moment_it_is_the_asteroid() -> None:
    """|X| / cos a + |Y| / sin a <= 4 f_max, which holds the other two: the asteroid of 1000 N, and a disc of it."""
    outline = outline_together(square(), 0.0, np.linspace(0.0, 2.0 * pi, 7200, endpoint=False))
    np.testing.assert_allclose((np.abs(outline) ** (2.0 / 3.0)).sum(axis=1), 100.0, rtol=1e-6)
    # Chords of a curve that bends inwards lie outside of it, most near the cusps.
    assert area_of(outline) == pytest.approx(asteroid_area(1000.0), rel=1e-4)
    # Tangents of a circle: 2e-6 more.
    assert apart(square(), 0.0).volume == pytest.approx(pi * 1e6, rel=3e-6)


def test_each_at_its_own_angle_is_the_boundary_of_the_whole_set() -> None:
    """With the moment beside them, corners of the polygon are on the boundary that the allocator's margin knows."""
    corners = apart(square(), MOMENT).vertices[::120]
    for surge, sway in corners.tolist():
        for moment in (MOMENT, -MOMENT):
            tau = np.array([surge, sway, 0.0, moment])
            # Corners of the tangents are 2.4e-6 outside.
            assert scale_to_boundary(VESSEL, None, tau) == pytest.approx(1.0, abs=4e-6)


def test_a_set_within_the_next(study: AzimuthStudy) -> None:
    bearings = np.linspace(0.0, 2.0 * pi, 181)
    asteroid = study.limit * np.column_stack([np.cos(bearings) ** 3, np.sin(bearings) ** 3])
    loads, _ = best_together(study.square, study.moment, asteroid[:, 0], asteroid[:, 1])
    assert (loads <= 1.0 + 1e-9).all()
    assert (study.apart_set.load(study.together_outline) <= 1.0).all()


def test_figures_of_the_paper(study: AzimuthStudy) -> None:
    assert (study.moment, study.reserved, study.limit) == pytest.approx((50.0, 62.5, 750.0), rel=1e-9)
    example = study.cases[0]
    assert (example.surge, example.sway) == pytest.approx((700.0, -120.0))
    assert example.reduced == pytest.approx(example.printed, abs=0.5)
    assert example.angle == pytest.approx(example.printed_angle, abs=0.05)
    # At the same angle with other thrusts a third more, and all of it with an angle for each.
    assert example.together / example.asteroid == pytest.approx(4.0 / 3.0, rel=1e-5)
    assert example.apart > 1.39


def test_step_2_keeps_an_angle_that_is_no_good(study: AzimuthStudy) -> None:
    kept = study.cases[1]
    assert (kept.surge, kept.sway) == pytest.approx((100.0, 400.0))
    assert kept.asteroid > 1.0
    assert kept.needed_at == pytest.approx(937.0, abs=0.5)
    assert kept.largest_at == pytest.approx(270.65, abs=0.05)
    assert kept.pseudo_at == pytest.approx(0.912, abs=1e-3)
    # The thrusts along which nothing comes out save it: this one demand, not all.
    assert kept.multiple_at == pytest.approx(1.0387, abs=1e-4)
    assert 0.0 < study.shares.kept_and_short < study.shares.kept_in_vain < study.shares.asteroid


def test_areas_and_shares(study: AzimuthStudy) -> None:
    assert study.asteroid_area / study.together_area == pytest.approx(0.5744, abs=1e-4)
    assert study.asteroid_area / study.apart_area == pytest.approx(0.2185, abs=1e-4)
    areas = (study.asteroid_area, study.together_area, study.apart_area)
    shares = (study.shares.asteroid, study.shares.together, study.shares.apart)
    for area, share in zip(areas, shares, strict=True):
        # Three standard deviations of a share of 400.
        assert share == pytest.approx(area / 4e6, abs=0.075)


@pytest.mark.parametrize("name", ["ukwial", "mmt300", "cybership3", "drillship"])
def test_other_vessels_have_no_such_square(name: str) -> None:
    assert square_of(load_vessel(name)) is None
