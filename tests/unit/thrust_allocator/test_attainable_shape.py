"""Ball, volume and outlines of the attainable set."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.attainable import ForceSet, force_set, largest_ball, projection, section, volume
from thrust_allocator.attainable.margin import reach

VESSEL = load_vessel("cybership3")


def reversible(name: str) -> Vessel:
    """Every thruster as strong astern as ahead, as [Ruth] chapter 7 takes them."""
    document = load_vessel(name).model_dump()
    for thruster in document["thrusters"]:
        thruster["thrust"]["min"] = -thruster["thrust"]["max"]
    return Vessel.model_validate(document)


def sphere(count: int) -> FloatArray:
    points = np.random.default_rng(1).normal(size=(count, 3))
    unit: FloatArray = points / np.linalg.norm(points, axis=1)[:, None]
    return unit


@pytest.mark.parametrize(("name", "radius"), [("cybership3_ch7", 12.46), ("cybership3", 13.56)])
def test_largest_ball_where_the_bound_of_lemma_7_2_is_6(name: str, radius: float) -> None:
    """[Ruth] (7.119): 6.0 as printed, 8.5 without the factor of 1 / sqrt 2 that its proof does not need."""
    vessel = reversible(name)
    length, thrust = np.hypot(vessel.lever_x, vessel.lever_y).mean(), vessel.thrust_max.mean()
    forces = force_set(vessel)
    limits = forces.upper[:, None]
    torque_scale = np.array([1.0, 1.0, 1.0 / length])
    scaled = np.concatenate([forces.first * limits, forces.second * limits]) * torque_scale / thrust
    bound = min(1.0, length) * thrust * np.linalg.svd(scaled, compute_uv=False)[2]
    if name == "cybership3_ch7":
        assert bound == pytest.approx(8.5, abs=0.05)
        assert bound / math.sqrt(2.0) == pytest.approx(6.0, abs=0.05)
    ball = largest_ball(forces)
    assert ball.radius == pytest.approx(radius, abs=0.005)
    assert ball.radius > bound


@pytest.mark.parametrize("angles", [None, [np.pi / 2, 0.6, -0.8, 0.8]])
def test_no_direction_reaches_less_than_the_ball(angles: list[float] | None) -> None:
    for forces in (force_set(VESSEL, angles), force_set(VESSEL, angles).scaled(8.9)):
        ball = largest_ball(forces)
        heights = forces.support(sphere(200_000))
        # One in 200,000 is within 0.02 rad of the least; h changes by the reach of the set times that, or less.
        assert ball.radius <= heights.min() <= ball.radius + 0.02 * heights.max()
        assert float(forces.support(ball.direction)) == pytest.approx(ball.radius, rel=1e-12)
        assert float(np.linalg.norm(ball.direction)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_no_search_by_chance_finds_less_than_the_ball(seed: int) -> None:
    random = np.random.default_rng(seed)
    n = int(random.integers(2, 7))
    turns = random.random(n) < 0.5
    turns[0] = True
    x, y = random.normal(size=(2, n))
    angle = random.uniform(-np.pi, np.pi, n)
    polar = np.column_stack([np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)])
    first = np.where(turns[:, None], np.column_stack([np.ones(n), np.zeros(n), -y]), polar)
    second = np.where(turns[:, None], np.column_stack([np.zeros(n), np.ones(n), x]), 0.0)
    forces = ForceSet(first, second, -random.uniform(0.0, 3.0, n), random.uniform(0.0, 5.0, n), turns, 1.0)
    near = sphere(200_000)
    for width in (0.03, 0.003, 0.0003, 0.00003):
        best = near[np.argmin(forces.support(near))]
        closer = best + width * np.random.default_rng(2).normal(size=(50_000, 3))
        near = np.concatenate([closer / np.linalg.norm(closer, axis=1)[:, None], best[None]])
    dense = float(forces.support(near).min())
    ball = largest_ball(forces)
    # The radius is the height in a direction, so that it cannot be too small; the search may end in another valley.
    assert float(forces.support(ball.direction)) == pytest.approx(ball.radius, rel=1e-12)
    assert ball.radius <= dense * (1.0 + 1e-9)


def test_no_ball_in_a_flat_set() -> None:
    assert largest_ball(force_set(VESSEL, [np.pi / 2] * 4)).radius == 0.0
    assert largest_ball(force_set(VESSEL, enabled=[False, True, False, False])).radius == 0.0
    assert largest_ball(force_set(VESSEL, enabled=[False] * 4)).radius == 0.0


def test_volume_of_a_zonotope_is_that_of_its_corners() -> None:
    forces = force_set(VESSEL, [np.pi / 2, 0.6, -0.8, 0.8])
    corners = np.array(np.meshgrid(*zip(forces.lower, forces.upper, strict=True))).reshape(4, -1).T @ forces.first
    assert volume(forces) == pytest.approx(ConvexHull(corners).volume, rel=1e-12)


@pytest.mark.parametrize(
    "enabled", [[True] * 4, [False, True, True, True], [True, True, True, False], [True, False, True, True]]
)
def test_volume_with_turning_thrusters_is_the_integral_of_the_reach(enabled: list[bool]) -> None:
    forces = force_set(VESSEL, enabled=enabled)
    # Coordinates in which the set is about as wide in every direction, so that few rays do.
    spread = np.cov(forces.support_point(sphere(20_000)).T)
    white = np.linalg.inv(np.linalg.cholesky(spread)).T
    rounder = dataclasses.replace(forces, first=forces.first @ white, second=forces.second @ white)
    reaches = np.array([reach(rounder, ray)[0] for ray in sphere(20_000)])
    by_rays = 4.0 / 3.0 * np.pi * reaches**3 / np.linalg.det(white)
    error = by_rays.std() / np.sqrt(len(by_rays))
    assert error < 0.01 * by_rays.mean()
    assert volume(forces) == pytest.approx(by_rays.mean(), abs=4.0 * error)


def test_volume_of_one_disc_and_one_segment_is_a_cylinder() -> None:
    # Azimuth thruster in the origin, a moment of 2 m either way: area pi r^2 times 2 * 2.
    first, second = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    forces = ForceSet(first, second, np.array([-3.0, -1.0]), np.array([3.0, 1.0]), np.array([True, False]), 1.0)
    assert volume(forces) == pytest.approx(36.0 * np.pi, rel=1e-12)
    assert largest_ball(forces).radius == pytest.approx(2.0, rel=1e-12)


def test_volume_of_a_flat_set_is_none() -> None:
    # All at right angles to surge, but for cos(pi / 2) = 6e-17; 1e5 N^2 N m is the volume of the turning vessel.
    assert volume(force_set(VESSEL, [np.pi / 2] * 4)) == pytest.approx(0.0, abs=1e-9)
    assert volume(force_set(VESSEL, enabled=[False] * 4)) == 0.0


@pytest.mark.parametrize("angles", [None, [np.pi / 2, 0.6, -0.8, 0.8]])
@pytest.mark.parametrize("axes", [("surge", "sway"), ("surge", "yaw"), ("sway", "yaw")])
def test_sections_lie_within_projections(angles: list[float] | None, axes: tuple[str, str]) -> None:
    forces = force_set(VESSEL, angles)
    cut, shadow = section(forces, *axes), projection(forces, *axes, points=2880)
    hull = ConvexHull(shadow)
    # 2880 corners of a round shadow of radius 40 leave out 40 (1 - cos(pi / 2880)) = 2.4e-5, less where it is flatter.
    assert (cut @ hull.equations[:, :2].T + hull.equations[:, 2] <= 1e-4).all()
    assert ConvexHull(cut).volume < hull.volume


def test_projection_of_a_zonotope_is_the_shadow_of_its_corners() -> None:
    forces = force_set(VESSEL, [np.pi / 2, 0.6, -0.8, 0.8])
    corners = np.array(np.meshgrid(*zip(forces.lower, forces.upper, strict=True))).reshape(4, -1).T @ forces.first
    shadow = ConvexHull(projection(forces, "surge", "yaw", points=3600)).volume
    assert shadow == pytest.approx(ConvexHull(corners[:, [0, 2]]).volume, rel=1e-12)


def test_unknown_axes_are_refused() -> None:
    with pytest.raises(InputError, match="vertical: expected one of surge, sway, yaw, found 'heave'"):
        section(force_set(VESSEL), "surge", "heave")
    with pytest.raises(InputError, match="vertical: expected another axis than surge"):
        projection(force_set(VESSEL), "surge", "surge")
