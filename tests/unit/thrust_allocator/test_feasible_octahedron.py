"""Octahedron and priority: the papers' examples, and what holds for any demand."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import (
    axis_limits,
    coupled_axes,
    octahedron_load,
    octahedron_volume,
    pseudo_inverse,
    reduce_by_priority,
    reduce_proportionally,
    served_limits,
)

THRUST = np.full(4, 250.0)
PRINTED = np.array([875.0, 485.0, 332.0])
DEMANDS = np.random.default_rng(7).normal(size=(10_000, 3)) * PRINTED * 1.5
ROUNDING = 1e-12  # of a limit: sums of a few products


def skewed() -> FloatArray:
    """Return B of [Garus-F] section 4, from its own angles."""
    alpha, phi = np.radians([29.0, -29.0, 151.0, 209.0]), np.radians([-26.5, 26.5, 206.5, 153.5])
    return np.array([np.cos(alpha), np.sin(alpha), 0.4 * np.sin(alpha - phi)])


def four_axes() -> FloatArray:
    """Return the same with two vertical thrusters and heave as third axis."""
    B = np.zeros((4, 6))
    B[np.ix_([0, 1, 3], range(4))] = skewed()
    B[2, 4:] = 1.0
    return B


def zonotope_scale(B: FloatArray, thrust: FloatArray, tau: FloatArray) -> FloatArray:
    """Return how many times each demand (k, 3) is attainable: every pair of columns spans facets."""
    columns = (B * thrust).T
    normals = np.array([np.cross(columns[i], columns[j]) for i, j in combinations(range(len(columns)), 2)])
    heights = np.abs(normals @ columns.T).sum(axis=1)
    with np.errstate(divide="ignore"):
        scales: FloatArray = (heights / np.abs(tau @ normals.T)).min(axis=-1)
    return scales


def test_limits_of_the_paper() -> None:
    # 329.7 N m from its own angles, where 332 is printed.
    assert axis_limits(skewed(), THRUST) == pytest.approx([874.62, 484.81, 329.66], abs=0.01)


def test_example_of_garus() -> None:
    tau = np.array([700.0, -120.0, 30.0])
    assert octahedron_load(tau, PRINTED) == pytest.approx(1.14, abs=0.005)
    reduced = reduce_proportionally(tau, PRINTED)
    # 700 / 1.1378 is 615.2 where 614.6 is printed: 0.1 % of rounding on the way, and half a digit at the end.
    np.testing.assert_allclose(reduced, [614.6, -105.4, 26.3], rtol=2e-3, atol=0.05)
    assert reduced[0] == pytest.approx(615.2, abs=0.05)


def test_garus_n_means_30() -> None:
    """[Garus-N] says 50 N m, and computes 1.14 with 30; with 50 it is 1.198."""
    assert octahedron_load(np.array([700.0, -120.0, 50.0]), PRINTED) == pytest.approx(1.198, abs=5e-4)


def test_priority_on_the_papers_data() -> None:
    """(14) by hand: surge kept leaves 0.2; weights a, b share it."""
    tau = np.array([700.0, -120.0, 50.0])
    for a, b in ((1.0, 1.0), (1.0, 3.0), (2.0, 1.0)):
        reduced = reduce_by_priority(tau, PRINTED, np.array([1.0, a, b]), 0)
        t1, t2, t3 = PRINTED
        sway = -a * 120.0 * (t2 * t3 / t1) * (t1 - 700.0) / (a * 120.0 * t3 + b * 50.0 * t2)
        yaw = (b / a) * (50.0 / -120.0) * sway
        assert reduced == pytest.approx([700.0, sway, yaw], rel=1e-12)
        assert octahedron_load(reduced, PRINTED) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("B", [skewed(), four_axes()])
def test_feasible_and_proportional(B: FloatArray) -> None:
    n, m = B.shape[1], len(B)
    thrust = np.full(n, 250.0)
    groups = coupled_axes(B)
    limits, inverse = served_limits(B, thrust), pseudo_inverse(B, np.ones(n, dtype=bool))
    assert limits == pytest.approx(axis_limits(B, thrust), rel=1e-12)
    demands = np.random.default_rng(1).normal(size=(10_000, m)) * limits * 1.5
    reduced = np.zeros_like(demands)
    for group in map(list, groups):
        reduced[:, group] = reduce_proportionally(demands[:, group], limits[group])
        ratios = reduced[:, group] / demands[:, group]
        # The same factor, which a quotient knows to its last digits.
        np.testing.assert_allclose(ratios, ratios[:, :1] * np.ones(len(group)), rtol=1e-15)
        outside = octahedron_load(demands[:, group], limits[group]) > 1.0
        assert 1000 < outside.sum() < 9999
        np.testing.assert_array_equal(ratios[~outside], 1.0)
        np.testing.assert_allclose(octahedron_load(reduced[outside][:, group], limits[group]), 1.0, rtol=1e-14)
    thrusts = reduced @ inverse.T
    assert (np.abs(thrusts) <= thrust * (1.0 + ROUNDING)).all()
    np.testing.assert_allclose(thrusts @ B.T, reduced, atol=ROUNDING * limits.max())


def test_pseudo_inverse_reaches_no_further() -> None:
    """With symmetrical thrusters the octahedron is all that the pseudo-inverse can do: here "if and only if" holds."""
    limits, inverse = served_limits(skewed(), THRUST), pseudo_inverse(skewed(), np.ones(4, dtype=bool))
    largest = (np.abs(DEMANDS @ inverse.T) / THRUST).max(axis=1)
    np.testing.assert_allclose(largest, octahedron_load(DEMANDS, limits), rtol=1e-12)


def test_if_and_only_if_does_not_hold() -> None:
    """The octahedron refuses what the thrusters can give, here with every one of them at 80 % or less."""
    B, limits = skewed(), axis_limits(skewed(), THRUST)
    tau = np.array([400.0, -200.0, 100.0])
    assert octahedron_load(tau, limits) == pytest.approx(1.173, abs=1e-3)
    # Thrusts along the one direction that gives nothing take the largest down.
    thrusts = pseudo_inverse(B, np.ones(4, dtype=bool)) @ tau
    spare = -0.5 * (thrusts.max() + thrusts.min()) * np.sign(B[0] * B[1] * B[2])
    np.testing.assert_allclose(B @ np.sign(B[0] * B[1] * B[2]), 0.0, atol=1e-12)
    assert np.abs(thrusts).max() > 250.0
    assert np.abs(thrusts + spare * np.sign(B[0, 0] * B[1, 0] * B[2, 0])).max() <= 0.87 * 250.0
    assert zonotope_scale(B, THRUST, tau[None])[0] > 1.14


def test_two_thirds_of_the_volume() -> None:
    """4/3 of the product against 2: any four thrusters placed symmetrically."""
    B = skewed()
    zonotope = sum(abs(np.linalg.det(2.0 * THRUST[0] * B[:, list(triple)])) for triple in combinations(range(4), 3))
    assert octahedron_volume(axis_limits(B, THRUST)) / zonotope == pytest.approx(2.0 / 3.0, rel=1e-12)
    assert octahedron_volume(PRINTED) == pytest.approx(4.0 / 3.0 * np.prod(PRINTED))


def test_inner_bound_holds_for_any_demand() -> None:
    reduced = reduce_proportionally(DEMANDS, axis_limits(skewed(), THRUST))
    scales = zonotope_scale(skewed(), THRUST, reduced)
    assert scales.min() >= 1.0 - ROUNDING
    # Half of these could have been served with 14 % more and above.
    assert np.median(scales) == pytest.approx(1.146, abs=0.02)


def test_a_lost_thruster_breaks_the_printed_limits() -> None:
    """With three, full surge comes with sway and yaw: the printed corner is not attainable, the served one is."""
    B = skewed()
    thrust = np.array([250.0, 250.0, 250.0, 0.0])
    printed, served = axis_limits(B, thrust), served_limits(B, thrust)
    assert zonotope_scale(B[:, :3], thrust[:3], np.diag(printed)).max() < 0.7
    assert (served > 0.0).all()
    reduced = reduce_proportionally(DEMANDS, served)
    inverse = pseudo_inverse(B, thrust > 0.0)
    assert (np.abs(reduced @ inverse.T) <= thrust * (1.0 + ROUNDING)).all()
    np.testing.assert_array_equal(inverse[3], 0.0)
    np.testing.assert_allclose(reduced @ inverse.T @ B.T, reduced, atol=ROUNDING * 1e3)


def test_two_thrusters_left() -> None:
    """B B' is singular: what is nearest is given, within limits."""
    B, thrust = skewed(), np.array([250.0, 0.0, 0.0, 250.0])
    inverse, limits = pseudo_inverse(B, thrust > 0.0), served_limits(B, thrust)
    np.testing.assert_allclose(inverse @ B @ inverse, inverse, atol=1e-12)
    thrusts = reduce_proportionally(DEMANDS, limits) @ inverse.T
    assert (np.abs(thrusts) <= thrust * (1.0 + ROUNDING)).all()
    assert np.isfinite(thrusts).all()


def test_axis_weights_have_a_say_only_in_a_miss() -> None:
    B, weight = skewed(), np.array([1.0, 30.0, 1.0])
    every = np.ones(4, dtype=bool)
    np.testing.assert_allclose(pseudo_inverse(B, every, weight), pseudo_inverse(B, every), rtol=1e-10, atol=1e-15)
    two = np.array([True, False, False, True])
    tau = np.array([100.0, 50.0, 20.0])
    missed = [tau - B @ pseudo_inverse(B, two, w) @ tau for w in (np.ones(3), weight)]
    assert abs(missed[1][1]) < 0.1 * abs(missed[0][1])


def test_groups() -> None:
    assert coupled_axes(skewed()) == ((0, 1, 2),)
    assert coupled_axes(four_axes()) == ((0, 1, 3), (2,))
    # Nothing left in an axis: a group of its own.
    assert coupled_axes(np.array([[1.0, 1.0], [0.0, 0.0], [1.0, -1.0]])) == ((0, 2), (1,))


def test_no_demand_and_no_thruster() -> None:
    zero = np.zeros(3)
    for limits in (PRINTED, zero):
        assert octahedron_load(zero, limits) == 0.0
        np.testing.assert_array_equal(reduce_proportionally(zero, limits), zero)
        np.testing.assert_array_equal(reduce_by_priority(zero, limits, np.ones(3), 1), zero)
    assert np.isinf(octahedron_load(np.ones(3), zero))
    np.testing.assert_array_equal(reduce_proportionally(np.ones(3), zero), zero)
    np.testing.assert_array_equal(served_limits(skewed(), np.zeros(4)), zero)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_single_axis_is_cut_at_its_limit(axis: int) -> None:
    """(3.3) divides by the first element: a demand without surge has none."""
    tau = np.zeros(3)
    tau[axis] = -3.0 * PRINTED[axis]
    expected = np.zeros(3)
    expected[axis] = -PRINTED[axis]
    for reduced in (
        reduce_proportionally(tau, PRINTED),
        *[reduce_by_priority(tau, PRINTED, np.ones(3), k) for k in range(3)],
    ):
        assert reduced == pytest.approx(expected, rel=1e-15)


def test_an_axis_without_thruster_takes_nothing_with_it() -> None:
    tau, limits = np.array([100.0, 5.0, 10.0]), np.array([200.0, 0.0, 40.0])
    np.testing.assert_array_equal(reduce_proportionally(tau, limits), [100.0, 0.0, 10.0])
    np.testing.assert_array_equal(reduce_by_priority(tau, limits, np.ones(3), 1), [100.0, 0.0, 10.0])


@pytest.mark.parametrize("kept", [0, 1, 2, None])
@pytest.mark.parametrize("weights", [(1.0, 1.0, 1.0), (1.0, 5.0, 0.2), (3.0, 0.01, 1.0)])
def test_priority_for_any_demand(kept: int | None, weights: tuple[float, float, float]) -> None:
    weight = np.array(weights)
    reduced = reduce_by_priority(DEMANDS, PRINTED, weight, kept)
    factor = reduced / DEMANDS
    load = octahedron_load(reduced, PRINTED)
    assert (factor >= 0.0).all()
    assert (factor <= 1.0).all()
    outside = octahedron_load(DEMANDS, PRINTED) > 1.0
    np.testing.assert_array_equal(reduced[~outside], DEMANDS[~outside])
    # All of the octahedron is used.
    np.testing.assert_allclose(load[outside], 1.0, rtol=1e-12)
    others = [i for i in range(3) if i != kept]
    if kept is not None:
        own = np.abs(DEMANDS[:, kept]) / PRINTED[kept]
        np.testing.assert_allclose(factor[:, kept], np.minimum(1.0, 1.0 / own), rtol=1e-15)
        np.testing.assert_array_equal(factor[outside & (own > 1.0)][:, others], 0.0)
    # (10) among the axes that do not get all they ask for; the others have had no larger share.
    claim = factor[outside][:, others] / weight[others]
    full = factor[outside][:, others] >= 1.0
    short = np.where(full, np.nan, claim)
    np.testing.assert_allclose(np.nanmax(short, axis=1), np.nanmin(short, axis=1), rtol=1e-9, atol=1e-12)
    assert (np.where(full, claim, 0.0).max(axis=1) <= np.nanmax(short, axis=1) + 1e-12).all()


def test_no_more_than_was_demanded() -> None:
    """(14) as printed orders 273 N of sway where 120 were asked; what it leaves goes to yaw."""
    tau, weight = np.array([350.0, -120.0, 300.0]), np.array([1.0, 50.0, 1.0])
    t1, t2, t3 = PRINTED
    printed = -50.0 * 120.0 * (t2 * t3 / t1) * (t1 - 350.0) / (50.0 * 120.0 * t3 + 300.0 * t2)
    assert printed == pytest.approx(-271.2, abs=0.1)
    reduced = reduce_by_priority(tau, PRINTED, weight, 0)
    np.testing.assert_allclose(reduced, [350.0, -120.0, (1.0 - 350.0 / t1 - 120.0 / t2) * t3], rtol=1e-12)


def test_without_one_of_the_others() -> None:
    """(14) divides by tau_2."""
    reduced = reduce_by_priority(np.array([700.0, 0.0, 300.0]), PRINTED, np.ones(3), 0)
    np.testing.assert_allclose(reduced, [700.0, 0.0, 0.2 * 332.0], rtol=1e-12)


@pytest.mark.parametrize("weights", [np.array([1.0, 0.0, 1.0]), np.array([1.0, np.nan, 1.0]), np.ones(2)])
def test_bad_weights(weights: FloatArray) -> None:
    with pytest.raises(InputError, match=r"priority\.weights: expected 3 finite numbers above 0, found"):
        reduce_by_priority(np.ones(3), PRINTED, weights, 0)


def test_bad_axis() -> None:
    with pytest.raises(InputError, match=r"priority\.axis: expected an index from 0 to 2, found 3"):
        reduce_by_priority(np.ones(3), PRINTED, np.ones(3), 3)
