"""Minimum gain with windows of directions, [Ruth] 7.5.2 and 7.7."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from support.singularity_cases import mirrored, unit_vectors
from thrust_allocator.singularity import (
    horizon_window,
    minimum_gain,
    scaled_configuration,
    scaling_of,
    window_minimum_gain,
)

VESSEL = load_vessel("cybership3_ch7")
SCALING = scaling_of(VESSEL)
METHODS = ["theorem_7_1", "theorem_7_2", "lemma_7_1", "exact"]
ONE_WAY = np.array([False, True, True, True])
starts = st.lists(st.floats(-math.pi, math.pi), min_size=4, max_size=4).map(np.array)
widths = st.lists(st.sampled_from([0.0, 0.3, 1.0, 2.5, math.pi]), min_size=4, max_size=4).map(np.array)


def not_above(small: float, large: float) -> bool:
    return small <= large * (1.0 + 1e-9) + 1e-9


def projected_length(low: np.ndarray, high: np.ndarray, v: np.ndarray) -> np.ndarray:
    """|P(B_G' v)| for v of shape (count, 3), thruster by thruster; the tunnel thruster is a line."""
    share = SCALING.thrust_max / SCALING.mean_thrust_max
    total = (share[0] * (v[:, 1] + v[:, 2] * SCALING.lever_x[0] / SCALING.typical_arm)) ** 2
    for j in (1, 2, 3):
        x = share[j] * (v[:, 0] - v[:, 2] * SCALING.lever_y[j] / SCALING.typical_arm)
        y = share[j] * (v[:, 1] + v[:, 2] * SCALING.lever_x[j] / SCALING.typical_arm)
        size, angle = np.hypot(x, y), (np.arctan2(y, x) - low[j]) % (2.0 * math.pi)
        width = high[j] - low[j]
        outside = np.maximum(0.0, np.maximum(np.cos(angle), np.cos(angle - width)))
        total += (size * np.where(angle <= width, 1.0, outside)) ** 2
    return np.sqrt(total)


@given(starts, widths)
def test_order_of_the_methods(low: np.ndarray, width: np.ndarray) -> None:
    gain = {method: window_minimum_gain(VESSEL, low, low + width, method=method).gain for method in METHODS}  # type: ignore[arg-type]
    assert not_above(gain["theorem_7_1"], gain["theorem_7_2"])
    assert not_above(max(gain["theorem_7_2"], gain["lemma_7_1"]), gain["exact"])
    assert not_above(gain["exact"], minimum_gain(scaled_configuration(VESSEL)).gain)


@given(starts, widths, st.integers(0, 2**32 - 1))
def test_exact_gain_by_brute_force(low: np.ndarray, width: np.ndarray, seed: int) -> None:
    gain, direction = window_minimum_gain(VESSEL, low, low + width, method="exact")
    around = direction + 1e-3 * unit_vectors(seed, 200)
    v = np.vstack([unit_vectors(seed, 2000), around / np.linalg.norm(around, axis=1)[:, None]])
    assert gain <= projected_length(low, low + width, v).min() + 1e-12
    assert projected_length(low, low + width, direction[None])[0] == pytest.approx(gain, abs=1e-12)


@given(starts, st.sampled_from(METHODS))
def test_a_window_without_width_is_a_fixed_thruster(azimuth: np.ndarray, method: str) -> None:
    fixed = minimum_gain(scaled_configuration(VESSEL, azimuth), ONE_WAY, method)  # type: ignore[arg-type]
    assert window_minimum_gain(SCALING, azimuth, azimuth, method=method).gain == pytest.approx(  # type: ignore[arg-type]
        fixed.gain, rel=1e-9, abs=1e-9
    )
    both = window_minimum_gain(SCALING, azimuth, azimuth, unidirectional=np.zeros(4, dtype=bool))
    assert both.gain == pytest.approx(minimum_gain(scaled_configuration(VESSEL, azimuth)).gain, abs=1e-12)


def test_full_turns_are_freely_rotating_thrusters() -> None:
    whole = window_minimum_gain(VESSEL, np.zeros(4), np.full(4, 2.0 * math.pi))
    assert whole.gain == pytest.approx(minimum_gain(scaled_configuration(VESSEL)).gain, rel=1e-12)


@given(starts, widths, st.sampled_from(["theorem_7_2", "exact"]))
def test_a_wider_window_has_no_smaller_exact_gain(low: np.ndarray, width: np.ndarray, method: str) -> None:
    narrow = window_minimum_gain(VESSEL, low, low + width, method="exact").gain
    wider = np.minimum(low + width + 0.4, low + math.pi)
    assert not_above(narrow, window_minimum_gain(VESSEL, low, wider, method="exact").gain)


@given(starts, widths, st.sampled_from(METHODS))
def test_port_and_starboard_mirror(low: np.ndarray, width: np.ndarray, method: str) -> None:
    here = window_minimum_gain(SCALING, low, low + width, method=method).gain  # type: ignore[arg-type]
    there = window_minimum_gain(mirrored(SCALING), -low - width, -low, method=method).gain  # type: ignore[arg-type]
    assert there == pytest.approx(here, rel=1e-6, abs=1e-9)


@given(starts, widths)
def test_lost_thrusters_are_left_out(low: np.ndarray, width: np.ndarray) -> None:
    enabled = np.array([True, True, True, False])
    less = window_minimum_gain(VESSEL, low, low + width, enabled, method="exact").gain
    assert not_above(less, window_minimum_gain(VESSEL, low, low + width, method="exact").gain)


def test_horizon_window_7_120_to_7_122() -> None:
    low, high = horizon_window([0.1, 1.0, -2.0], [0.0, 0.2, 1.0], 5.0, [-1.0, -0.4, -3.0], [1.0, 3.0, 0.0])
    np.testing.assert_allclose(low, [0.1, 0.6, -2.0 - 0.5 * math.pi], atol=1e-15)
    np.testing.assert_allclose(high, [0.1, 2.0, -2.0], atol=1e-15)
    low, high = horizon_window([0.0], [1.0], 100.0)
    assert high[0] - low[0] == math.pi
    # 180 deg between them is convex, at any present angle.
    for angle in np.linspace(-3.0, 3.0, 50):
        low, high = horizon_window(np.full(4, angle), np.ones(4), 100.0)
        assert window_minimum_gain(VESSEL, low, high).gain >= 0.0


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match=r"azimuth_high\[2\] - azimuth_low\[2\]: expected 0 to pi, or 2 pi and more"):
        window_minimum_gain(VESSEL, np.zeros(4), [0.0, 1.0, 3.5, 1.0])
    with pytest.raises(InputError, match=r"azimuth_high\[1\]"):
        window_minimum_gain(VESSEL, np.zeros(4), [0.0, -0.1, 0.5, 1.0])
    with pytest.raises(InputError, match="expected another than 'svd'"):
        window_minimum_gain(VESSEL, np.zeros(4), np.ones(4), method="svd")
    with pytest.raises(InputError, match="horizon, azimuth_rate: expected numbers not below 0"):
        horizon_window([0.0], [1.0], -1.0)
    with pytest.raises(InputError, match="turn_low: expected numbers not above 0"):
        horizon_window([0.0], [1.0], 1.0, turn_low=[0.1])
    with pytest.raises(InputError, match="turn_high: expected numbers not below 0"):
        horizon_window([0.0], [1.0], 1.0, turn_high=[-0.1])
