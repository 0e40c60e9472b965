"""The active-set method on random problems, also degenerate ones, by certificates that do not come from it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.random import Generator

from marine_model.guards import FloatArray
from thrust_allocator.plan.polygon import rotating_corners
from thrust_allocator.program.active_set import IntArray, polish, solve
from thrust_allocator.program.projection import project

INSTANCES = 10_000
CORNERS = 24
# Rounding of a sum of doubles, as a share of its terms; a handful of operations each.
ROUNDING = 20 * 2.2e-16


@dataclass
class Problem:
    B: FloatArray
    weight: FloatArray
    corners: FloatArray
    count: IntArray
    compliance: FloatArray
    tau: FloatArray

    @property
    def shapes(self) -> list[FloatArray]:
        return [c[:k] for c, k in zip(self.corners, self.count, strict=True)]

    def cost(self, force: FloatArray) -> float:
        slack = self.tau - np.einsum("jix,jx->i", self.B, force)
        return 0.5 * float((slack**2 / self.compliance).sum() + (self.weight[:, None] * force**2).sum())


def shape(random: Generator, size: float) -> FloatArray:
    """A point, a segment (of no length too), a cone, a disc, a polygon of any place, or that of a step; or nothing."""
    kind = random.integers(0, 7)
    if kind == 0:
        return np.zeros((0, 2))
    if kind == 1:
        return size * random.normal(size=(1, 2))
    if kind == 2:
        direction = random.uniform(-math.pi, math.pi)
        ends = np.sort(random.choice([-1.0, 0.0, 0.2, 0.2, 1.0, random.normal()], 2))
        return size * ends[:, None] * np.array([math.cos(direction), math.sin(direction)])
    if kind == 3:
        start, width = random.uniform(-math.pi, math.pi), random.uniform(1e-3, 3.1)
        angle = np.linspace(start, start + width, random.integers(2, 9))
        return size * np.vstack([np.zeros((1, 2)), np.column_stack([np.cos(angle), np.sin(angle)])])
    if kind == 4:
        angle = np.linspace(-math.pi, math.pi, CORNERS, endpoint=False)
        return size * np.column_stack([np.cos(angle), np.sin(angle)])
    if kind == 5:
        angle = np.sort(random.uniform(-math.pi, math.pi, random.integers(3, 9)))
        return size * (np.column_stack([np.cos(angle), random.uniform(0.05, 1.0) * np.sin(angle)]) + random.normal(2))
    lower = size * random.choice([-1e-3, 0.0, random.uniform(0.0, 0.8)])
    upper = max(lower, 0.0) + size * random.choice([1e-6, 1e-3, random.uniform(0.01, 1.0)])
    # A window of no width puts two edges in one line.
    low = random.choice([0.0, -1e-4, -random.uniform(0.0, 1.04)])
    high = random.choice([0.0, 1e-4, random.uniform(0.0, 1.04)])
    corners = np.zeros((5, 2))
    return corners[: rotating_corners(random.uniform(-math.pi, math.pi), low, high, lower, upper, 1e-3, corners)]


def problem(random: Generator, vessel_like: bool) -> Problem:
    n = int(random.integers(1, 21))
    m = 3 if vessel_like else int(random.integers(1, 7))
    scale = 10.0 ** random.choice([0, 0, 0, -3, 4])
    B = random.normal(size=(n, m, 2))
    if vessel_like:
        B[:, 0], B[:, 1] = [1.0, 0.0], [0.0, 1.0]
    shapes = [shape(random, scale * 10.0 ** random.choice([0, 0, -2, 1])) for _ in range(n)]
    corners, count = np.zeros((n, CORNERS, 2)), np.array([len(found) for found in shapes])
    for j, found in enumerate(shapes):
        corners[j, : len(found)] = found
    reach = np.abs(corners).max(axis=(1, 2)).sum()
    return Problem(
        B,
        random.uniform(0.5, 5.0, n) ** 2 * 10.0 ** random.choice([0, 0, 2, -2]),
        corners,
        count,
        1.0 / (1000.0 * random.choice([1.0, 10.0, 0.1], m)) ** 2,
        random.normal(size=m) * reach * random.choice([0.0, 0.01, 0.3, 1.0, 10.0]),
    )


def answer(of: Problem, start: FloatArray | None = None) -> tuple[int, FloatArray, FloatArray, float]:
    n, m = len(of.weight), len(of.tau)
    multiplier = np.zeros(m) if start is None else start.copy()
    force, face, work = np.zeros((n, 2)), np.zeros(n, dtype=np.int64), np.zeros((m, m + 1))
    what = (of.B, of.weight, of.corners, of.count, of.compliance, of.tau)
    steps = solve(*what, multiplier, force, face, work)
    left = polish(*what, multiplier, force, face, work, np.zeros((n, 2)))
    return steps, multiplier, force, left


def check(of: Problem, force: FloatArray, left: float) -> float:
    """Check feasibility and optimality from the answer alone; return the share by which its cost may be too high."""
    slack = of.tau - np.einsum("jix,jx->i", of.B, force)
    multiplier = slack / of.compliance
    # What rounding alone makes of the slack: demands and corners of unlike sizes are added.
    terms = np.abs(of.tau) + np.einsum("jix,jx->i", np.abs(of.B), np.abs(of.corners).max(axis=1))
    fuzzy = ROUNDING * terms / of.compliance
    gap = allowed = 0.0
    for j, corners in enumerate(of.shapes):
        if not len(corners):
            continue
        size = np.abs(corners).max()
        if len(corners) > 2:
            edge = np.roll(corners, -1, axis=0) - corners
            length = np.hypot(*edge.T)
            outwards = np.column_stack([edge[:, 1], -edge[:, 0]])[length > 0] / length[length > 0][:, None]
            beyond = (outwards * (force[j] - corners[length > 0])).sum(axis=1)
            assert beyond.max() <= 1e-9 * min(size, 1.0) + 1e-15 * size
        # Convex cost: no point of the set is better by more than this, the largest of a linear function over corners.
        downhill = of.B[j].T @ multiplier - of.weight[j] * force[j]
        gap += max(0.0, float(((corners - force[j]) @ downhill).max()))
        allowed += float((np.abs(of.B[j]).T @ fuzzy).sum()) * 2.0 * size
    assert left <= 1e-8
    return max(0.0, gap - allowed) / max(of.cost(force), 1e-300)


@pytest.mark.parametrize("vessel_like", [True, False])
def test_random_problems_are_solved_to_the_optimum(vessel_like: bool) -> None:
    random = np.random.default_rng(11)
    warm: FloatArray | None = None
    hard = 0
    for k in range(INSTANCES // 2):
        of = problem(random, vessel_like)
        # From the multipliers of another problem too, as far away as they may be.
        start = warm if k % 2 and warm is not None and len(warm) == len(of.tau) else None
        steps, warm, force, left = answer(of, start)
        assert steps >= 0  # never asks for another solver
        assert check(of, force, left) <= 1e-9
        hard += steps > 5
    assert hard > INSTANCES // 20  # the primal method has been needed often


def test_same_optimum_as_another_solver() -> None:
    """daqp, on a problem without slack and corners: variables are the forces, rows the edges."""
    random = np.random.default_rng(12)
    compared = 0
    for _ in range(600):
        of = problem(random, vessel_like=True)
        shapes = of.shapes
        live = [j for j, corners in enumerate(shapes) if len(corners) > 2]
        # What is a point or a segment has no inside: left to the other tests. One size, or daqp's tolerances are off.
        if not live or max(np.abs(shapes[j]).max() for j in live) > 100.0:
            continue
        of = Problem(of.B[live], of.weight[live], of.corners[live], of.count[live], of.compliance, of.tau)
        n = len(live)
        F = of.B.transpose(1, 0, 2).reshape(3, 2 * n)
        H = F.T @ (F / of.compliance[:, None]) + np.diag(np.repeat(of.weight, 2))
        rows, limits = [], []
        for j, corners in enumerate(of.shapes):
            edge = np.roll(corners, -1, axis=0) - corners
            outwards = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.hypot(*edge.T)[:, None]
            for normal, corner in zip(outwards, corners, strict=True):
                row = np.zeros(2 * n)
                row[2 * j : 2 * j + 2] = normal
                rows.append(row)
                limits.append(float(normal @ corner))
        found = daqp.solve(
            H, -F.T @ (of.tau / of.compliance), np.array(rows), np.array(limits), np.full(len(rows), -1e30),
            primal_tol=1e-10,
        )  # fmt: skip
        if found[2] != 1:
            continue
        theirs = found[0].reshape(n, 2)
        _, _, force, _ = answer(of)
        mine = of.cost(force)
        # Never worse; and where daqp is exact, the same. It may be better by what it violates, times the price of that.
        violation = max(0.0, float((np.array(rows) @ found[0] - limits).max()))
        price = float(np.abs(F.T @ ((of.tau - F @ force.ravel()) / of.compliance)).sum())
        assert mine <= of.cost(theirs) * (1.0 + 1e-9) + 2.0 * violation * price + 1e-12
        compared += abs(mine - of.cost(theirs)) <= 1e-9 * mine + 2.0 * violation * price + 1e-12
    assert compared > 100


def nearest(corners: FloatArray, point: FloatArray) -> FloatArray:
    """By hand: inside, or the nearest of the nearest points of all edges."""
    edges = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
    if len(corners) > 2 and all((b - a)[0] * (point - a)[1] - (b - a)[1] * (point - a)[0] >= 0.0 for a, b in edges):
        return point
    found = []
    for a, b in edges:
        squared = float((b - a) @ (b - a))
        share = min(max(float((point - a) @ (b - a)) / squared, 0.0), 1.0) if squared > 0.0 else 0.0
        found.append(a + share * (b - a))
    return min(found, key=lambda at: float((point - at) @ (point - at)))


def test_nearest_point_of_a_polygon() -> None:
    random = np.random.default_rng(13)
    for _ in range(5000):
        corners = shape(random, 1.0)
        if not len(corners):
            continue
        point = random.normal(size=2) * random.choice([0.0, 0.1, 1.0, 100.0])
        x, y, face = project(np.ascontiguousarray(corners), len(corners), *point)
        # Two points at nearly one distance: their distance is rounding's square root at most.
        expected = nearest(corners, point)
        assert math.dist((x, y), point) == pytest.approx(math.dist(expected, point), rel=1e-12, abs=1e-14)
        if face == 0:
            np.testing.assert_array_equal((x, y), point)


@settings(max_examples=200, deadline=None)
@given(
    angle=st.floats(-math.pi, math.pi),
    size=st.sampled_from([1e-6, 1e-3, 1.0]),
    distance=st.sampled_from([1e6, 1e9, 1e12]),
)
def test_nearest_point_to_one_far_away_is_the_furthest_along(angle: float, size: float, distance: float) -> None:
    """Multipliers of a saturated step put a point so far away that distances to two corners are one number."""
    corners = size * np.array([[-1.0, -1.0], [1.0, -0.5], [1.2, 0.3], [0.1, 1.0], [-1.1, 0.2]])
    away = np.array([math.cos(angle), math.sin(angle)])
    x, y, _ = project(corners, 5, *(distance * away))
    assert float(away @ (x, y)) >= float((corners @ away).max()) - 1e-9 * size - size * size / distance


def test_corners_in_one_place_and_in_one_line() -> None:
    twice = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]])
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for point in ([2.0, -1.0], [2.0, 0.5], [0.5, -3.0], [2.0, 2.0], [-1.0, -1.0], [-1.0, 0.5], [0.4, 0.6], [1.0, 0.5]):
        assert project(twice, 6, *point)[:2] == pytest.approx(project(square, 4, *point)[:2], abs=0.0)
    rng = np.random.default_rng(14)
    for _ in range(300):
        tau = rng.normal(size=3) * 5.0
        costs = []
        for corners in (twice, square):
            of = Problem(
                np.tile(np.array([[1.0, 0.0], [0.0, 1.0], [0.3, -0.7]]), (2, 1, 1)), np.array([1.0, 3.0]),
                np.tile(corners, (2, 1, 1)), np.array([len(corners)] * 2), np.full(3, 1e-6), tau,
            )  # fmt: skip
            steps, _, force, left = answer(of)
            assert steps >= 0
            assert check(of, force, left) <= 1e-9
            costs.append(of.cost(force))
        assert costs[0] == pytest.approx(costs[1], rel=1e-12)


def test_no_demand_and_nothing_to_give() -> None:
    of = Problem(
        np.zeros((2, 3, 2)), np.ones(2), np.zeros((2, 5, 2)), np.zeros(2, dtype=np.int64), np.full(3, 1e-6), np.ones(3)
    )
    steps, multiplier, force, left = answer(of, np.array([math.nan, math.inf, 0.0]))
    assert steps >= 0
    assert left == 0.0
    np.testing.assert_array_equal(force, 0.0)
    np.testing.assert_allclose(multiplier, 1e6, rtol=1e-15)
