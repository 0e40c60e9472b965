"""Theorem 7.3 and Lemma 7.2: what a minimum gain promises about the attainable set."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from marine_model import load_vessel
from marine_model.errors import InputError
from support.singularity_cases import fixed_configurations, unit_vectors
from thrust_allocator.singularity import (
    lemma_7_2,
    minimum_gain,
    minimum_norm_thrust,
    scaled_configuration,
    scaling_of,
    theorem_7_3,
)

SCALING = scaling_of(load_vessel("cybership3_ch7"))


@settings(max_examples=40)
@given(
    fixed_configurations(),
    st.sampled_from(["theorem_7_1", "theorem_7_2", "lemma_7_1", "exact"]),
    st.integers(0, 2**32 - 1),
)
def test_every_force_up_to_the_gain_is_attainable(case: tuple[np.ndarray, np.ndarray], method: str, seed: int) -> None:
    """By linear programming: the largest multiple of a direction within thrusts of [-1, 1], or [0, 1] one way."""
    B, one_way = case
    gain, worst = minimum_gain(B, one_way, method)  # type: ignore[arg-type]
    if gain < 1e-6:  # below the tolerances of the linear program
        return
    k = B.shape[1]
    limits = [(0.0 if one_way[j] else -1.0, 1.0) for j in range(k)]
    for tau in [worst, *unit_vectors(seed, 5)]:
        answer = linprog(
            [*np.zeros(k), -1.0], A_eq=np.column_stack([B, -tau]), b_eq=np.zeros(3), bounds=[*limits, (0.0, None)]
        )
        assert answer.status == 0
        assert answer.x[-1] >= gain * (1.0 - 1e-6)


@given(st.lists(st.booleans(), min_size=4, max_size=4), st.integers(0, 2**32 - 1))
def test_rotating_pairs_stay_in_their_discs_without_the_root_of_two(enabled: list[bool], seed: int) -> None:
    B = scaled_configuration(SCALING, enabled=np.array(enabled))
    gain = minimum_gain(B).gain
    if gain == 0.0:
        return
    radius = lemma_7_2(gain, SCALING, as_printed=False).scaled
    assert radius == gain
    for tau in [minimum_gain(B).direction, *unit_vectors(seed, 5)]:
        thrust = minimum_norm_thrust(B, radius * tau)
        assert np.linalg.norm(thrust) <= 1.0 + 1e-9  # each pair's length is no more than that of all


def test_the_three_forms() -> None:
    scaled, weighted, unscaled = theorem_7_3(0.5, SCALING)
    assert scaled == 0.5
    assert weighted == pytest.approx(0.5 * SCALING.mean_thrust_max, rel=1e-15)
    assert unscaled == pytest.approx(SCALING.typical_arm * weighted, rel=1e-15)  # L_typ is below 1 m here
    for printed, theorem in zip(lemma_7_2(0.5, SCALING), theorem_7_3(0.5, SCALING), strict=True):
        assert printed == pytest.approx(theorem / np.sqrt(2.0), rel=1e-15)
    assert lemma_7_2(0.5, SCALING, as_printed=False) == theorem_7_3(0.5, SCALING)


@given(st.integers(0, 2**32 - 1))
def test_the_ball_in_newtons_lies_within_the_scaled_ball(seed: int) -> None:
    radius = theorem_7_3(0.8, SCALING).unscaled
    for tau in unit_vectors(seed, 20):
        assert np.linalg.norm(SCALING.scaled(radius * tau)) <= 0.8 * (1.0 + 1e-12)


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="gain: expected a number not below 0"):
        theorem_7_3(-0.1, SCALING)
    with pytest.raises(InputError, match="gain: expected a finite number"):
        lemma_7_2(float("nan"), SCALING)
