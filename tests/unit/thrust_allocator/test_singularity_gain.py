"""Minimum gain of fixed thrusters: how the methods relate, and what may not change them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from qpsolvers import solve_qp

from marine_model import load_vessel
from marine_model.errors import InputError
from support.singularity_cases import fixed_configurations, mirrored, projected, unit_vectors
from thrust_allocator.singularity import (
    minimum_gain,
    minimum_gains,
    minimum_norm_thrust,
    scaled_configuration,
    scaling_of,
)

BOUNDS = ["theorem_7_1", "theorem_7_2", "lemma_7_1"]
METHODS = [*BOUNDS, "exact"]
# Thrusts grow as 1 / gain and their errors with them; below SMALL a gain is compared on an absolute scale.
RELATIVE, SMALL = 1e-9, 1e-9
seeds = st.integers(0, 2**32 - 1)


def not_above(small: float, large: float) -> bool:
    return small <= large * (1.0 + RELATIVE) + SMALL


@given(fixed_configurations())
def test_order_of_the_methods(case: tuple[np.ndarray, np.ndarray]) -> None:
    B, one_way = case
    gain = {method: minimum_gain(B, one_way, method).gain for method in METHODS}  # type: ignore[arg-type]
    assert not_above(gain["theorem_7_1"], gain["theorem_7_2"])
    assert not_above(gain["theorem_7_1"], gain["lemma_7_1"])
    assert not_above(gain["theorem_7_2"], gain["exact"])
    assert not_above(gain["lemma_7_1"], gain["exact"])
    assert not_above(gain["exact"], minimum_gain(B, method="svd").gain)


@given(fixed_configurations())
def test_all_bidirectional_is_the_smallest_singular_value(case: tuple[np.ndarray, np.ndarray]) -> None:
    B, _ = case
    U, values, _ = np.linalg.svd(B)
    gain, direction = minimum_gain(B)
    assert gain == pytest.approx(values[-1], abs=1e-12)  # the accuracy of numpy's
    if values[-2] - values[-1] > 1e-6:  # far above rounding, so that the direction is well defined
        assert abs(direction @ U[:, -1]) == pytest.approx(1.0, abs=1e-9)
    # Theorem 7.2 as printed is exact then; split, it is below.
    for method in ("theorem_7_2", "exact"):
        assert minimum_gain(B, method=method).gain == pytest.approx(gain, rel=1e-6, abs=SMALL)


def test_theorem_7_2_and_lemma_7_1_are_not_ordered() -> None:
    """Splitting a column takes away what its two halves cancel (lowers it), and mixed-sign weights (raises it)."""
    one = np.array([[4.0, 4.0, 4.0], [-4.0, 0.0, 4.0]])
    printed, split, exact = (
        minimum_gain(one, [False, True, False], method).gain for method in ("theorem_7_2", "lemma_7_1", "exact")
    )
    assert split < 0.82 * printed
    assert printed == pytest.approx(exact, rel=1e-12)
    other = np.array([[-3.0, 2.0, -2.0, -4.0], [3.0, -2.0, 0.0, 2.0]])
    mask = [True, True, False, True]
    assert minimum_gain(other, mask, "lemma_7_1").gain > 1.015 * minimum_gain(other, mask, "theorem_7_2").gain


def test_greatest_lower_bound_is_for_combinations_not_for_the_shortest_thrust() -> None:
    """All unidirectional: combining basis solutions attains Lemma 7.1, and the shortest thrust does better."""
    B = np.array([[0.0, -4.0, -1.0, -1.0, 1.0], [4.0, 0.0, 1.0, 3.0, -1.0]])
    one_way = np.ones(5, dtype=bool)
    gain, direction = minimum_gain(B, one_way, "lemma_7_1")
    combined = np.zeros(5)
    for i, weight in enumerate(direction):
        unit = np.zeros(2)
        unit[i] = math.copysign(1.0, weight)
        combined += abs(weight) * minimum_norm_thrust(B, unit, one_way)
    assert 1.0 / np.linalg.norm(combined) == pytest.approx(gain, rel=1e-12)
    assert minimum_gain(B, one_way, "exact").gain > 1.2 * gain


@given(fixed_configurations(), seeds)
def test_exact_gain_is_the_smallest_of_the_shortest_thrusts(case: tuple[np.ndarray, np.ndarray], seed: int) -> None:
    B, one_way = case
    gain, direction = minimum_gain(B, one_way, "exact")
    assume(gain > 1e-4)  # thrusts of 1e4 and more have errors that count
    at_worst = minimum_norm_thrust(B, direction, one_way)
    assert np.linalg.norm(at_worst) == pytest.approx(1.0 / gain, rel=1e-9)
    for tau in unit_vectors(seed, 20):
        thrust = minimum_norm_thrust(B, tau, one_way)
        assert thrust is not None
        np.testing.assert_allclose(B @ thrust, tau, atol=1e-9)
        assert (thrust[one_way] >= -1e-9 * np.linalg.norm(thrust)).all()
        assert not_above(gain, 1.0 / np.linalg.norm(thrust))


@given(fixed_configurations(), seeds)
def test_exact_gain_by_brute_force(case: tuple[np.ndarray, np.ndarray], seed: int) -> None:
    """min |P(B' v)| over many v: on the sphere, and close about the direction found."""
    B, one_way = case
    gain, direction = minimum_gain(B, one_way, "exact")
    around = direction + 1e-3 * unit_vectors(seed, 200)
    v = np.vstack([unit_vectors(seed, 2000), around / np.linalg.norm(around, axis=1)[:, None]])
    sampled = np.linalg.norm(projected(B, one_way, v), axis=1).min()
    assert gain <= sampled + 1e-12
    # |P(B' v)| changes by at most the largest singular value times the change of v.
    assert np.linalg.norm(projected(B, one_way, direction[None])[0]) == pytest.approx(gain, abs=1e-12)


@given(fixed_configurations(), seeds)
def test_shortest_thrust_equals_that_of_a_general_solver(case: tuple[np.ndarray, np.ndarray], seed: int) -> None:
    B, one_way = case
    k = B.shape[1]
    assume(minimum_gain(B, one_way, "exact").gain > 1e-2)  # quadprog loses digits with long thrusts
    tau = unit_vectors(seed, 1)[0]
    expected = solve_qp(
        np.eye(k), np.zeros(k), A=B, b=tau, lb=np.where(one_way, 0.0, -1e6), ub=np.full(k, 1e6), solver="quadprog"
    )
    np.testing.assert_allclose(minimum_norm_thrust(B, tau, one_way), expected, atol=1e-7)


@given(fixed_configurations(), seeds)
def test_gain_does_not_exceed_that_of_shortest_thrusts(case: tuple[np.ndarray, np.ndarray], seed: int) -> None:
    """P(B' v) is the shortest thrust for the force it gives; of no other thrust can a gain be promised."""
    B, one_way = case
    thrusts = projected(B, one_way, unit_vectors(seed, 200))
    lengths = np.linalg.norm(thrusts, axis=1)
    forces = np.linalg.norm(thrusts @ B.T, axis=1)
    for method in METHODS:
        gain = minimum_gain(B, one_way, method).gain  # type: ignore[arg-type]
        assert (forces >= gain * lengths * (1.0 - RELATIVE) - SMALL).all()


@given(fixed_configurations(), st.sampled_from(METHODS))
def test_zero_gain_comes_with_a_direction_that_cannot_be_produced(
    case: tuple[np.ndarray, np.ndarray], method: str
) -> None:
    B, one_way = case
    one_way = np.ones_like(one_way)
    gain, direction = minimum_gain(B, one_way, method)  # type: ignore[arg-type]
    assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-12)
    if gain == 0.0:
        # No thruster pushes that way: v' B <= 0 in every column, up to what counts as no gain.
        assert (direction @ B <= 1e-9).all()


@pytest.mark.parametrize("method", METHODS)
def test_two_thrusters_cannot_produce_three_components(method: str) -> None:
    B = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, -0.5]])
    gain, direction = minimum_gain(B, method=method)  # type: ignore[arg-type]
    assert gain == 0.0
    np.testing.assert_allclose(direction @ B, 0.0, atol=1e-15)


def test_no_thruster_has_no_gain() -> None:
    gain, direction = minimum_gain(np.zeros((3, 0)))
    assert gain == 0.0
    assert np.linalg.norm(direction) == 1.0


@given(fixed_configurations(), st.sampled_from(METHODS), st.randoms(use_true_random=False))
def test_order_of_columns_does_not_count(case: tuple[np.ndarray, np.ndarray], method: str, random) -> None:  # type: ignore[no-untyped-def]
    B, one_way = case
    order = list(range(B.shape[1]))
    random.shuffle(order)
    gain = minimum_gain(B, one_way, method).gain  # type: ignore[arg-type]
    assert minimum_gain(B[:, order], one_way[order], method).gain == pytest.approx(  # type: ignore[arg-type]
        gain, rel=1e-6, abs=SMALL
    )


@given(fixed_configurations(), st.sampled_from(METHODS))
def test_sign_of_bidirectional_columns_does_not_count(case: tuple[np.ndarray, np.ndarray], method: str) -> None:
    B, one_way = case
    flipped = np.where(one_way, B, -B)
    gain = minimum_gain(B, one_way, method).gain  # type: ignore[arg-type]
    assert minimum_gain(flipped, one_way, method).gain == pytest.approx(gain, rel=1e-6, abs=SMALL)  # type: ignore[arg-type]
    # All signs at once: what could be produced is produced the other way round.
    other, direction = minimum_gain(-B, one_way, method)  # type: ignore[arg-type]
    assert other == pytest.approx(gain, rel=1e-6, abs=SMALL)
    assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-12)


@given(fixed_configurations(), st.sampled_from(METHODS), st.floats(1e-3, 1e3))
def test_gain_grows_with_the_matrix(case: tuple[np.ndarray, np.ndarray], method: str, factor: float) -> None:
    B, one_way = case
    gain = minimum_gain(B, one_way, method).gain  # type: ignore[arg-type]
    scaled = minimum_gain(factor * B, one_way, method).gain  # type: ignore[arg-type]
    assert scaled == pytest.approx(factor * gain, rel=1e-6, abs=SMALL * factor)


@given(fixed_configurations(), seeds)
def test_exact_gain_does_not_depend_on_the_axes(case: tuple[np.ndarray, np.ndarray], seed: int) -> None:
    """Unlike the theorems, whose basis solutions are along the axes."""
    B, one_way = case
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    gain = minimum_gain(B, one_way, "exact").gain
    assert minimum_gain(Q @ B, one_way, "exact").gain == pytest.approx(gain, rel=1e-7, abs=1e-9)


@given(
    st.lists(st.floats(-math.pi, math.pi), min_size=4, max_size=4),
    st.lists(st.booleans(), min_size=4, max_size=4),
    st.sampled_from(METHODS),
)
def test_port_and_starboard_mirror(azimuth: list[float], one_way: list[bool], method: str) -> None:
    here = scaling_of(load_vessel("cybership3_ch7"))
    there = mirrored(here)
    mask = np.array(one_way)
    gain = minimum_gain(scaled_configuration(here, azimuth), mask, method).gain  # type: ignore[arg-type]
    other = minimum_gain(scaled_configuration(there, -np.array(azimuth)), mask, method)  # type: ignore[arg-type]
    assert other.gain == pytest.approx(gain, rel=1e-6, abs=SMALL)


@settings(max_examples=30)
@given(fixed_configurations(), st.sampled_from(METHODS), seeds)
def test_many_at_once_equal_one_by_one(case: tuple[np.ndarray, np.ndarray], method: str, seed: int) -> None:
    B, one_way = case
    many = B + 0.1 * np.random.default_rng(seed).normal(size=(7, *B.shape))
    gains, directions = minimum_gains(many, one_way, method)  # type: ignore[arg-type]
    for i, one in enumerate(many):
        gain, direction = minimum_gain(one, one_way, method)  # type: ignore[arg-type]
        assert gains[i] == gain
        np.testing.assert_array_equal(directions[i], direction)


def test_six_rows() -> None:
    """Six degrees of freedom, [Ruth] remark 7.1: twelve thrusters of gain 1/2, one for each way to push."""
    B = 0.5 * np.hstack([np.eye(6), -np.eye(6)])
    for method in BOUNDS:
        expected = 0.5 / math.sqrt(6.0 * 12.0) if method == "theorem_7_1" else 0.5
        gain = minimum_gain(B, np.ones(12, dtype=bool), method).gain  # type: ignore[arg-type]
        # T_f is 2 in all twelve rows: 1 / (sqrt(6) 2 sqrt(12)).
        assert gain == pytest.approx(expected, rel=1e-12)


def test_one_row() -> None:
    gain, direction = minimum_gain([[3.0, -0.5]], [True, True], "exact")
    assert gain == pytest.approx(0.5, abs=1e-15)
    np.testing.assert_array_equal(direction, [-1.0])


def test_bad_input_is_refused() -> None:
    B = np.eye(3)
    with pytest.raises(InputError, match=r"B_scaled: expected shape \(m, k\), found \(3,\)"):
        minimum_gain([1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="B_scaled: expected finite"):
        minimum_gain(B * np.nan)
    with pytest.raises(InputError, match=r"unidirectional: expected 3 bools, found shape \(2,\)"):
        minimum_gain(B, [True, False])
    with pytest.raises(InputError, match=r"method: expected one of auto, svd, .*, found 'fast'"):
        minimum_gain(B, method="fast")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="expected another than 'svd'"):
        minimum_gain(B, [True, False, False], "svd")
    with pytest.raises(InputError, match="at most 3 rows for 'exact', found 4"):
        minimum_gain(np.eye(4), method="exact")
    with pytest.raises(InputError, match="B_scaled: expected rank 3, found 2"):
        minimum_norm_thrust(B[:, :2], [1.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"B_scaled: expected shape \(count, m, k\)"):
        minimum_gains(B)


def test_what_cannot_be_produced_has_no_shortest_thrust() -> None:
    assert minimum_norm_thrust(np.eye(3), [0.0, 0.0, -1.0], [False, False, True]) is None


def test_nearly_parallel_planes_hide_no_cell() -> None:
    """Thrusters 1e-9 from opposite leave cells 1e-9 wide between their planes; the minimum lies in one of them."""
    noise = 1e-9 * np.random.default_rng(7).normal(size=(3, 5))
    B = np.array([[2.0, 1.0, -1.0, 1.0, -2.0], [-2.0, 0.0, -1.0, 0.0, 1.0], [0.0, 2.0, 1.0, 2.0, 0.0]]) + noise
    one_way = np.array([True, True, True, False, True])
    gains = [
        minimum_gain(B[:, order], one_way[order], "exact").gain
        for order in (np.random.default_rng(seed).permutation(5) for seed in range(20))
    ]
    # The largest entries are 2: rounding of their products.
    assert max(gains) - min(gains) < 1e-14
    assert gains[0] < 1e-8
