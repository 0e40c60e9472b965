"""Parts of singularity avoidance: slopes by finite differences, descent, search, routes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.guards import FloatArray
from thrust_allocator.engine import Engine
from thrust_allocator.singularity import scaled_configuration, scaling_of
from thrust_allocator.singularity.avoidance_descent import descend
from thrust_allocator.singularity.avoidance_detour import find_detour
from thrust_allocator.singularity.avoidance_route import Route, find_route, toll_of
from thrust_allocator.singularity.avoidance_search import Grid
from thrust_allocator.singularity.avoidance_thrusters import (
    Thrusters,
    cost_slope,
    gain_at,
    gain_slope,
    static_cost,
)

VESSEL = load_vessel("cybership3")
ENGINE = Engine(VESSEL)
SCALING = scaling_of(VESSEL)
SCALE = np.array([1.0, 1.0, 1.0 / SCALING.typical_arm]) / SCALING.mean_thrust_max
THRUSTERS = Thrusters(
    ENGINE.columns,
    ENGINE.columns * SCALE[:, None] * VESSEL.thrust_max[:, None, None],
    ENGINE.weights.thrust,
    1.0 / ENGINE.weights.slack,
    VESSEL.thrust_min.copy(),
    VESSEL.thrust_max.copy(),
    np.arange(4),
    np.arange(1, 4),
)
RATE = np.array([0.0, 0.5, 0.5, 0.5])
CIRCLE = np.array([0.0, np.inf, np.inf, np.inf])
FIXED = VESSEL.fixed_direction.copy()
GRID = Grid(THRUSTERS, FIXED)
LIMIT = 0.5

angles = st.lists(st.floats(-math.pi, math.pi), min_size=3, max_size=3).map(
    lambda three: np.array([math.pi / 2.0, *three])
)
demands = st.tuples(st.floats(-12.0, 12.0), st.floats(-9.0, 9.0), st.floats(-4.0, 4.0)).map(np.array)


def gain(azimuth: FloatArray) -> float:
    return gain_at(THRUSTERS, azimuth, np.empty(3))


def cost(azimuth: FloatArray, tau: FloatArray) -> float:
    return static_cost(THRUSTERS, azimuth, tau, np.zeros(3), np.empty(4))


@given(angles)
def test_gain_is_the_smallest_singular_value_of_the_scaled_configuration(azimuth: FloatArray) -> None:
    singular = np.linalg.svd(scaled_configuration(SCALING, azimuth), compute_uv=False)
    assert gain(azimuth) == pytest.approx(singular[-1], abs=1e-12)


@given(angles)
def test_slope_of_the_gain(azimuth: FloatArray) -> None:
    singular = np.linalg.svd(scaled_configuration(SCALING, azimuth), compute_uv=False)
    if singular[2] < 0.05 or singular[1] - singular[2] < 0.05:
        return  # bends there as much as it slopes
    slope = np.empty(4)
    gain_slope(THRUSTERS, azimuth, slope)
    for j in range(1, 4):
        step = 1e-6 * np.eye(4)[j]
        # Central differences of a function that bends by 1 / 0.05 at most: 1e-12 * 20 / 6, and rounding 1e-16 / 1e-6.
        assert slope[j] == pytest.approx((gain(azimuth + step) - gain(azimuth - step)) / 2e-6, abs=1e-7)
    assert slope[0] == 0.0


@given(angles, demands)
def test_slope_of_the_cost(azimuth: FloatArray, tau: FloatArray) -> None:
    multiplier, thrust, slope = np.zeros(3), np.empty(4), np.empty(4)
    value = static_cost(THRUSTERS, azimuth, tau, multiplier, thrust)
    if gain(azimuth) < 0.2 or value > 1e3:
        return  # the slack's weight makes it bend too much for differences
    cost_slope(THRUSTERS, azimuth, multiplier, thrust, slope)
    for j in range(1, 4):
        step = 1e-5 * np.eye(4)[j]
        found = (cost(azimuth + step, tau) - cost(azimuth - step, tau)) / 2e-5
        # Where a limit becomes active within the step the slope has a kink.
        assert slope[j] == pytest.approx(found, abs=1e-2 * max(1.0, value))


def test_cost_without_limits_has_a_closed_form() -> None:
    tau = np.array([2.0, 1.0, 0.5])
    azimuth = FIXED
    B = np.array([ENGINE.columns[j] @ [math.cos(azimuth[j]), math.sin(azimuth[j])] for j in range(4)]).T
    inverse = np.linalg.inv(np.diag(THRUSTERS.compliance) + B / THRUSTERS.weight @ B.T)
    assert cost(azimuth, tau) == pytest.approx(tau @ inverse @ tau, rel=1e-9)


@given(angles, demands)
@settings(max_examples=50)
def test_descent_never_costs_more_nor_has_less_gain(azimuth: FloatArray, tau: FloatArray) -> None:
    low, high = np.array([0.0, -0.1, -0.1, 0.0]), np.array([0.0, 0.1, 0.0, 0.1])
    end = azimuth.copy()
    reached = descend(THRUSTERS, tau, LIMIT, low, high, 10, end)
    assert reached == pytest.approx(cost(end, tau), rel=1e-9)
    assert reached <= cost(azimuth, tau)
    assert gain(end) >= min(LIMIT, gain(azimuth))
    # Rounding of angles that are added and subtracted.
    assert (end - azimuth >= low - 1e-15).all()
    assert (end - azimuth <= high + 1e-15).all()


@given(demands)
@settings(max_examples=15)
def test_search_is_no_worse_than_any_point_of_its_grid(tau: FloatArray) -> None:
    """A coarser grid within it, by brute force, after enough calls for all of it."""
    grid = Grid(THRUSTERS, FIXED)
    least = math.inf
    for node in grid.sufficient(LIMIT)[::7]:
        azimuth = FIXED.copy()
        for j in (1, 2, 3):
            azimuth[j] = (node % grid.points) * math.pi / grid.points
            node //= grid.points
        least = min(least, cost(azimuth, tau))
    for _ in range(len(grid.sufficient(LIMIT)) // 30 + 1):
        found, value = grid.best(THRUSTERS, FIXED, -CIRCLE, CIRCLE, tau, LIMIT)
    assert gain(found) >= LIMIT
    assert value <= least * (1.0 + 1e-6)


@given(angles, angles)
@settings(max_examples=25, deadline=None)
def test_route_turns_at_the_rate_and_ends_at_its_target(start: FloatArray, target: FloatArray) -> None:
    route = find_route(THRUSTERS, start, target, -CIRCLE, CIRCLE, RATE, LIMIT, 5.0, 0.2)
    assert route is not None
    np.testing.assert_array_equal(route.azimuth[0], start)
    # Half a turn may go either way.
    np.testing.assert_allclose(np.cos(route.azimuth[-1] - target), 1.0, atol=1e-12)
    assert (np.abs(np.diff(route.azimuth, axis=0)) <= RATE * route.spacing + 1e-9).all()
    straight = find_route(THRUSTERS, start, target, -CIRCLE, CIRCLE, RATE, LIMIT, 0.0, 0.2)
    assert straight is not None
    shortest = max(abs(math.remainder(t, 2.0 * math.pi)) / 0.5 for t in (target - start)[1:])
    assert straight.duration <= shortest * (1.0 + 1e-9) + straight.spacing * 1.2
    assert _time_below(route) <= _time_below(straight) + 4 * route.spacing


def _time_below(route: Route) -> float:
    return float(sum(gain(row) < LIMIT for row in route.azimuth)) * route.spacing


def test_a_route_out_of_its_window_is_refused() -> None:
    window = np.array([0.0, 0.5, 0.5, 0.5])
    target = FIXED + np.array([0.0, 1.0, 0.0, 0.0])
    assert find_route(THRUSTERS, FIXED, target, -window, window, RATE, LIMIT, 5.0, 0.2) is None


def test_toll_is_zero_where_nothing_costs_more_on_the_way() -> None:
    route = find_route(THRUSTERS, FIXED, FIXED + 0.3, -CIRCLE, CIRCLE, RATE, LIMIT, 5.0, 0.2)
    assert route is not None
    nothing = toll_of(THRUSTERS, route, np.zeros(3), 0.0, SCALE)
    # Rounding of the direction of least gain, whose margin is zero.
    assert nothing.excess < 1e-15
    assert nothing.shortfall < 1e-12
    # Ten times what the vessel has.
    assert toll_of(THRUSTERS, route, np.array([400.0, 0.0, 0.0]), 0.0, SCALE).shortfall > 10.0


@given(angles, angles)
@settings(max_examples=25, deadline=None)
def test_detour_keeps_the_gain(start: FloatArray, target: FloatArray) -> None:
    if min(gain(start), gain(target)) < LIMIT:
        return
    route = find_detour(THRUSTERS, GRID, start, target, RATE, LIMIT)
    if route is None:
        return
    np.testing.assert_array_equal(route.azimuth[0], start)
    np.testing.assert_allclose(np.abs(np.cos(route.azimuth[-1] - target)), 1.0, atol=1e-12)
    assert (np.abs(np.diff(route.azimuth, axis=0)) <= RATE * route.spacing + 1e-9).all()
    # Between the points where it is checked, 10 deg / 4 apart, the gain can dip: a column of length 1.5 turns by
    # 0.022 rad from the nearest.
    for a, b in zip(route.azimuth[:-1], route.azimuth[1:], strict=True):
        for share in np.linspace(0.0, 1.0, 9):
            assert gain(a + share * (b - a)) >= LIMIT - 3 * 1.5 * 0.022
