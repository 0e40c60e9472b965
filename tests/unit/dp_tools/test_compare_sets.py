"""Sets of demands along fixed directions: closed forms, volumes, random demands, the demand that is refused in vain."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from dp_tools.compare.group import Group, groups_of
from dp_tools.compare.group_study import GroupStudy, study_group
from dp_tools.compare.polytope import (
    Polytope,
    determinant_volume,
    inside,
    octahedron,
    pseudo_inverse_set,
    zonotope,
)
from dp_tools.compare.program import ATTAINED, ConstrainedProgram
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.attainable import scale_to_boundary
from thrust_allocator.feasible import octahedron_volume

SHIPS = ("ukwial", "mmt300", "cybership3", "drillship")
# Of sums and products of a few numbers.
ROUNDING = 1e-9


def first(name: str) -> tuple[Vessel, Group]:
    vessel = load_vessel(name)
    return vessel, groups_of(vessel)[0]


@cache
def study(name: str, demands: int = 300) -> GroupStudy:
    return study_group(*first(name), demands, np.random.default_rng(4))


# Polytopes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("m", [1, 2, 3, 4])
def test_boxes_and_octahedra(m: int) -> None:
    sides = np.arange(1.0, m + 1.0)
    box = zonotope(np.diag(sides), np.full(m, -1.0), np.full(m, 1.0))
    assert box.volume == pytest.approx(2.0**m * np.prod(sides), rel=ROUNDING)
    assert octahedron(sides).volume == pytest.approx(octahedron_volume(sides), rel=ROUNDING)
    assert len(octahedron(sides).vertices) == 2 * m
    np.testing.assert_allclose(box.load(2.0 * np.diag(sides)), 2.0, rtol=ROUNDING)
    np.testing.assert_allclose(octahedron(sides).load(np.diag(sides)), 1.0, rtol=ROUNDING)
    assert octahedron(sides).load(sides) == pytest.approx(m, rel=ROUNDING)
    assert octahedron(sides).load(np.zeros(m)) == 0.0


def test_sections_and_faces_of_a_cube() -> None:
    cube = zonotope(np.eye(3), np.full(3, -1.0), np.full(3, 2.0))
    assert [len(face) for face in cube.faces()] == [4] * 6
    square = cube.section((0, 2))
    assert square.volume == pytest.approx(9.0, rel=ROUNDING)
    # Counter-clockwise, so that it can be drawn.
    x, y = square.vertices.T
    assert 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) == pytest.approx(9.0, rel=ROUNDING)
    assert cube.share_from(np.array([1.0, 0.0, 0.0]), np.array([0.5, -0.1, 0.0])) == pytest.approx(2.0, rel=ROUNDING)


def test_the_sets_differ_beside_a_third_force_only() -> None:
    """Rhombic dodecahedron and octahedron: the same diamond without yaw; at half of it a square, and half of that."""
    group = first("ukwial")[1]
    exact, octahedral = group.attainable(), group.printed_octahedron()
    for yaw, ratio in ((0.0, 1.0), (0.5 * group.printed[2], 2.0)):
        at = np.array([0.0, 0.0, yaw])
        areas = []
        for body in (exact, octahedral):
            corners = body.slice_corners((0, 1), at)
            assert corners is not None
            x, y = corners.T
            areas.append(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
        assert areas[0] / areas[1] == pytest.approx(ratio, rel=1e-6)
    assert exact.slice_corners((0, 1), np.array([0.0, 0.0, 1.001 * group.printed[2]])) is None


def test_the_origin_is_inside_or_there_is_no_load() -> None:
    with pytest.raises(InputError, match="attainable set: expected the origin inside, found it on the boundary"):
        Polytope(np.array([[1.0], [-1.0]]), np.array([1.0, 0.0]))


@pytest.mark.parametrize("name", SHIPS)
def test_volume_by_hull_and_by_determinants(name: str) -> None:
    for group in groups_of(load_vessel(name)):
        assert group.attainable().volume == pytest.approx(
            determinant_volume(group.columns, group.lower, group.upper), rel=ROUNDING
        )


@pytest.mark.parametrize("name", SHIPS)
def test_reach_is_that_of_the_allocators_margin(name: str) -> None:
    """Facets of pairs of columns, in the allocator; half-spaces of the hull of corners, here."""
    vessel, group = first(name)
    directions = np.random.default_rng(2).normal(size=(20, len(group.axes))) * group.printed
    for direction, load in zip(directions, group.attainable().load(directions), strict=True):
        tau = np.zeros(len(vessel.degrees_of_freedom))
        tau[list(group.places)] = direction
        assert 1.0 / load == pytest.approx(scale_to_boundary(vessel, vessel.fixed_direction, tau), rel=ROUNDING)


def test_a_thruster_that_pushes_one_way_only_is_refused() -> None:
    vessel = load_vessel("ukwial")
    thruster = vessel.thrusters[1]
    one_way = thruster.model_copy(update={"thrust": thruster.thrust.model_copy(update={"min": 0.0})})
    changed = vessel.model_copy(update={"thrusters": (vessel.thrusters[0], one_way, *vessel.thrusters[2:])})
    with pytest.raises(InputError, match="thruster 'bow_starboard': expected thrust both ways to compare, found 0 to"):
        groups_of(changed)


# Ukwial --------------------------------------------------------------------------------------------------------------


def test_groups_of_ukwial() -> None:
    horizontal, heave = groups_of(load_vessel("ukwial"))
    assert (horizontal.axes, horizontal.thrusters) == (("surge", "sway", "yaw"), (0, 1, 2, 3))
    assert (heave.axes, heave.thrusters, heave.units) == (("heave",), (4, 5), ("N",))
    assert heave.attainable().volume == pytest.approx(1000.0, rel=ROUNDING)
    # (3.1) to the digits of the print: 329.7 N m by the paper's own angles where it has 332.
    assert horizontal.printed == pytest.approx([875.0, 485.0, 329.7], abs=0.5)


def test_two_thirds() -> None:
    found = study("ukwial")
    volumes = found.volumes
    assert volumes.printed / volumes.exact == pytest.approx(2.0 / 3.0, rel=ROUNDING)
    assert volumes.pseudo_inverse == pytest.approx(volumes.printed, rel=ROUNDING)
    # The corners of the octahedron are attainable, none with anything to spare.
    np.testing.assert_allclose(found.corner_loads, 1.0, rtol=ROUNDING)
    # Rhombic dodecahedron: a quarter of the box, the octahedron a sixth. Standard deviation of a share of 300: 2.5 %.
    assert found.shares.attainable == pytest.approx(0.25, abs=0.08)
    assert found.shares.passed == found.shares.pseudo_inverse == pytest.approx(1.0 / 6.0, abs=0.08)
    assert found.shares.refused_in_vain == pytest.approx(found.shares.attainable - found.shares.passed, abs=1e-12)
    assert found.shares.passed_in_vain == 0.0


def test_what_is_refused_and_served() -> None:
    found = study("ukwial").refused
    assert found is not None
    group = first("ukwial")[1]
    assert found.load > 1.34
    assert found.multiple == pytest.approx(1.0 / 0.9, rel=3e-3)  # of a corner, to three digits
    assert np.abs(found.by_pseudo_inverse).max() > 330.0
    assert np.abs(found.by_program).max() <= 250.0 + 1e-9
    np.testing.assert_allclose(found.demand - group.columns @ found.by_program, found.residual, atol=1e-9)
    assert np.abs(found.residual).max() < 1e-3  # N, of 400: the slack is soft


def test_reductions_of_the_papers_demands() -> None:
    garus_f, garus_n = study("ukwial").reductions
    assert (garus_f.demand.tolist(), garus_n.demand.tolist()) == ([700.0, -120.0, 30.0], [700.0, -120.0, 50.0])
    given = {way.method: way.given for way in garus_f.ways}
    share = {way.method: way.share for way in garus_f.ways}
    np.testing.assert_allclose(given["proportional, (3.3)"], given["as printed"], rtol=2e-3)
    # By hand: loads 0.80034, 0.24752, 0.09101; of a rhombic dodecahedron the two largest count, of the octahedron all.
    assert share["proportional, (3.3)"] == pytest.approx(1.0 / 1.13887, abs=1e-5)
    assert share["exact, same direction"] == pytest.approx(1.0 / 1.04786, abs=1e-5)
    assert share["surge kept, (14)"] == pytest.approx((1.0 - 0.80034) / (0.24752 + 0.09101), abs=1e-4)
    assert share["exact, surge kept"] == pytest.approx((1.0 - 0.80034) / 0.24752, abs=1e-4)
    assert "as printed" not in {way.method for way in garus_n.ways}
    for one in (garus_f, garus_n):
        load = first("ukwial")[1].attainable().load(np.array([way.given for way in one.ways]))
        assert inside(load - 1e-6).all()  # the program's slack is soft


# Others --------------------------------------------------------------------------------------------------------------


def test_a_corner_that_is_not_attainable() -> None:
    """Full pitch of MMT-300 comes with heave that no thruster is left to hold."""
    found = study("mmt300")
    assert found.corner_loads == pytest.approx([1.0, 1.025, 1.136, 1.0], abs=1e-3)
    assert found.volumes.printed / found.volumes.exact == pytest.approx(0.1672, abs=1e-4)
    assert found.volumes.pseudo_inverse / found.volumes.exact == pytest.approx(2.0 / 3.0, rel=1e-6)
    group = found.group
    assert group.served[2] == pytest.approx(57.86, abs=0.01)
    assert inside(found.exact.load(np.diag(group.served))).all()


def test_weaker_astern() -> None:
    """With one limit for both ways CyberShip III's octahedron passes what is not attainable, and refuses what is."""
    found = study("cybership3")
    assert (found.corner_loads > 1.0).all()
    assert found.shares.passed_in_vain > 0.0
    assert found.shares.refused_in_vain > 0.1
    limits = [-1.0 / float(found.exact.load(-axis)) for axis in np.eye(3)]
    assert limits == pytest.approx([-12.75, -10.84, -7.59], abs=0.01)


@pytest.mark.parametrize("name", SHIPS)
def test_the_program_serves_the_attainable_and_nothing_else(name: str) -> None:
    shares = study(name).shares
    # Demands within 0.01 % of the boundary may fall on either side; of 300 there is hardly one.
    assert shares.program == pytest.approx(shares.attainable, abs=1.01 / 300.0)
    assert shares.largest_miss_inside is not None
    assert shares.largest_miss_inside < ATTAINED


@pytest.mark.parametrize("name", SHIPS)
def test_the_program_is_a_bounded_least_squares_problem(name: str) -> None:
    """The allocator's program for all axes at once, against scipy's solver for the group by itself."""
    vessel, group = first(name)
    program = ConstrainedProgram(vessel, group)
    gains = vessel.allocator
    slack = gains.slack_gain * np.array(gains.slack_weight)[list(group.places)]
    thrust = np.array(gains.thrust_weight)[list(group.thrusters)]
    matrix = np.vstack([slack[:, None] * group.columns, np.diag(thrust)])
    demands: FloatArray = np.random.default_rng(3).uniform(-1.0, 1.0, (15, len(group.axes))) * group.printed
    for demand in demands:
        wanted = np.concatenate([slack * demand, np.zeros(len(thrust))])
        other = lsq_linear(matrix, wanted, (group.lower, group.upper), method="bvls", tol=1e-12).x
        np.testing.assert_allclose(program.thrusts(demand), other, atol=1e-6 * group.upper.max())


def test_the_pseudo_inverse_within_limits() -> None:
    group = first("cybership3")[1]
    body = pseudo_inverse_set(group.inverse, group.lower, group.upper)
    thrusts = body.vertices @ group.inverse.T
    assert (thrusts <= group.upper * (1.0 + ROUNDING)).all()
    assert (thrusts >= group.lower * (1.0 + ROUNDING)).all()
    assert inside(group.attainable().load(body.vertices)).all()


def test_the_same_seed_gives_the_same_demands() -> None:
    one, same, other = (study_group(*first("ukwial"), 40, np.random.default_rng(seed)).shares for seed in (4, 4, 5))
    assert one == same
    assert one != other
