"""Maps of minimum gain over two angles, [Ruth] 7.6."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from thrust_allocator.singularity import gain_map, minimum_gain, scaled_configuration, scaling_of

VESSEL = load_vessel("cybership3_ch7")
EQUAL = scaling_of(VESSEL, equal_thrust=True)
ONE_WAY = np.array([False, True, True, True])
CASES = np.array([[1, 1, 1, 1], [0, 1, 1, 1], [1, 0, 1, 1], [1, 1, 0, 1], [1, 1, 1, 0]], dtype=bool)
GRID = np.linspace(-math.pi, math.pi, 72, endpoint=False)


@pytest.mark.parametrize("method", ["svd", "theorem_7_1", "theorem_7_2", "lemma_7_1", "exact"])
def test_map_equals_single_gains(method: str) -> None:
    one_way = None if method == "svd" else ONE_WAY
    first, second = GRID[::17], GRID[5::13]
    azimuth = np.array([0.0, 2.8, 0.0, 0.0])
    gains = gain_map(VESSEL, (3, 2), (first, second), azimuth, CASES, one_way, method)  # type: ignore[arg-type]
    assert gains.shape == (5, len(first), len(second))
    for case, enabled in enumerate(CASES):
        for p, a in enumerate(first):
            for q, b in enumerate(second):
                B = scaled_configuration(VESSEL, [0.0, 2.8, b, a], enabled)
                mask = None if one_way is None else one_way[enabled]
                expected = minimum_gain(B, mask, method).gain  # type: ignore[arg-type]
                assert gains[case, p, q] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_figures_7_4_to_7_11() -> None:
    """What the text says about them."""

    def over(alpha: float, enabled: np.ndarray, scaling: object = EQUAL) -> np.ndarray:
        return gain_map(scaling, (2, 3), (GRID, GRID), [0.0, alpha, 0.0, 0.0], enabled[None])[0]  # type: ignore[arg-type]

    intact, no_tunnel, no_bow = CASES[0], CASES[1], CASES[2]
    ahead, across = over(0.0, intact), over(math.pi / 2, intact)
    assert ahead.mean() > across.mean()  # Figure 7.4 the best, 7.5 the worst
    # Figure 7.6: without the tunnel thruster and alpha_2 = 0 near singular; Figure 7.7: at 90 deg hardly any effect.
    assert over(0.0, no_tunnel).max() < 0.5 * ahead.max()
    assert over(math.pi / 2, no_tunnel).mean() > 0.9 * across.mean()
    # Figure 7.8: loss of the forward azimuth nearly as Figures 7.5 and 7.7.
    assert over(math.pi / 2, no_bow).mean() == pytest.approx(over(math.pi / 2, no_tunnel).mean(), rel=0.1)
    # Figures 7.10, 7.11: with the true thrusts 90 deg is the better direction of thruster 2.
    true = scaling_of(VESSEL)
    assert over(math.pi / 2, intact, true).mean() > over(0.0, intact, true).mean()


@pytest.mark.parametrize("alpha", [math.pi / 2, math.pi])
def test_figures_7_12_and_7_13(alpha: float) -> None:
    """Theorem 7.1 lies below Theorem 7.2 and has the same shape; both are zero where a direction is missing."""
    low, high = (
        gain_map(EQUAL, (2, 3), (GRID, GRID), [0.0, alpha, 0.0, 0.0], None, ONE_WAY, method)[0]
        for method in ("theorem_7_1", "theorem_7_2")
    )
    assert (low <= high * (1.0 + 1e-9) + 1e-12).all()
    np.testing.assert_array_equal(low == 0.0, high == 0.0)
    assert 0.0 < (high > 0.0).mean() < 1.0
    assert np.corrcoef(low.ravel(), high.ravel())[0, 1] > 0.9  # "catches the main behavior"


def test_port_and_starboard_mirror() -> None:
    """With equal thrusts CyberShip III is its own mirror image, thrusters 3 and 4 swapped."""
    for method in ("theorem_7_2", "exact"):
        one, other = (
            gain_map(EQUAL, (2, 3), (sign * GRID, sign * GRID), [0.0, sign * 2.5, 0.0, 0.0], None, ONE_WAY, method)[0]  # type: ignore[arg-type]
            for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(other.T, one, rtol=1e-6, atol=1e-9)


def test_bad_input_is_refused() -> None:
    angles = (GRID, GRID)
    with pytest.raises(InputError, match="thrusters: expected indices of two azimuth thrusters below 4"):
        gain_map(VESSEL, (0, 2), angles, np.zeros(4))
    with pytest.raises(InputError, match="thrusters: expected indices of two azimuth thrusters below 4"):
        gain_map(VESSEL, (2, 2), angles, np.zeros(4))
    with pytest.raises(InputError, match=r"enabled: expected bools of shape \(cases, 4\)"):
        gain_map(VESSEL, (2, 3), angles, np.zeros(4), np.ones(4, dtype=bool))
    with pytest.raises(InputError, match="angles of thruster 3: expected finite"):
        gain_map(VESSEL, (2, 3), (GRID, [np.nan]), np.zeros(4))


def test_a_scaling_may_be_changed_by_hand() -> None:
    weak = replace(EQUAL, thrust_max=EQUAL.thrust_max * [1.0, 1.0, 1.0, 0.0])
    without = gain_map(EQUAL, (1, 2), (GRID[::9], GRID[::9]), np.zeros(4), CASES[4:])
    np.testing.assert_allclose(gain_map(weak, (1, 2), (GRID[::9], GRID[::9]), np.zeros(4)), without, atol=1e-12)
