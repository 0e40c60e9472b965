"""The numbers of [Ruth] chapter 7: its examples, (7.115)-(7.119), Tables 7.1 and 7.2, Figure 7.14."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from thrust_allocator.singularity import (
    lemma_7_2,
    minimum_gain,
    minimum_norm_thrust,
    project,
    scaled_configuration,
    scaling_of,
    theorem_7_3,
)

VESSEL = load_vessel("cybership3_ch7")
SCALING = scaling_of(VESSEL)
CRANE = np.array([[1.0, -0.5, 0.0], [0.0, 0.0, 1.0]])  # (7.26)
CRANE_ONE_WAY = [True, True, False]
TABLE_DIGIT = 0.01  # tables have two decimals; one more unit for the lever arms, which are read off (7.116)-(7.118)


def enabled(names: str) -> np.ndarray:
    return np.array([str(j + 1) in names for j in range(4)])


def test_example_7_1_basis_solutions() -> None:
    basis = [minimum_norm_thrust(CRANE, gamma, CRANE_ONE_WAY) for gamma in ([1, 0], [0, 1], [-1, 0], [0, -1])]
    np.testing.assert_allclose(np.transpose(basis), [[1, 0, 0, 0], [0, 0, 2, 0], [0, 1, 0, -1]], atol=1e-15)  # (7.28)


def test_example_7_2_theorem_7_1() -> None:
    gain, _ = minimum_gain(CRANE, CRANE_ONE_WAY, "theorem_7_1")
    assert gain == pytest.approx(1.0 / math.sqrt(12.0), abs=1e-15)
    assert round(gain, 2) == 0.29  # (7.48)


@pytest.mark.parametrize("method", ["theorem_7_2", "lemma_7_1", "exact", "auto"])
def test_examples_7_3_and_7_4(method: str) -> None:
    gain, direction = minimum_gain(CRANE, CRANE_ONE_WAY, method)  # type: ignore[arg-type]
    assert gain == pytest.approx(0.5, abs=1e-15)
    np.testing.assert_allclose(direction, [-1.0, 0.0], atol=1e-15)  # (7.124)


def test_example_7_4_with_the_columns_split_by_hand() -> None:
    split = np.array([[1.0, -0.5, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])  # (7.70)
    assert minimum_gain(split, np.ones(4, dtype=bool), "theorem_7_2").gain == pytest.approx(0.5, abs=1e-15)


def test_example_7_5() -> None:
    assert theorem_7_3(minimum_gain(CRANE, CRANE_ONE_WAY).gain, SCALING).scaled == pytest.approx(0.5, abs=1e-15)


def test_scaling_of_cybership_3() -> None:
    assert SCALING.mean_thrust_max == pytest.approx(8.9, abs=0.05)  # (7.115), one decimal
    assert SCALING.typical_arm == pytest.approx(0.79, abs=0.005)  # (7.116), two decimals


def test_freely_rotating_configuration_7_117() -> None:
    printed = [
        [0.0, 0.97, 0.0, 1.51, 0.0, 1.45, 0.0],
        [0.065, 0.0, 0.97, 0.0, 1.51, 0.0, 1.45],
        [0.070, 0.0, 0.68, 0.23, -1.67, -0.22, -1.61],
    ]
    # Two decimals, and the lever arms are known to their own.
    np.testing.assert_allclose(scaled_configuration(VESSEL), printed, atol=0.0075)


def test_singular_values_7_118() -> None:
    B = scaled_configuration(VESSEL)
    np.testing.assert_allclose(np.linalg.svd(B)[1], [3.1, 2.3, 1.20], atol=0.05)  # first two with one decimal
    assert minimum_gain(B).gain == pytest.approx(1.20, abs=0.005)


def test_attainable_ball_7_119() -> None:
    gain = minimum_gain(scaled_configuration(VESSEL)).gain
    assert lemma_7_2(gain, SCALING).unscaled == pytest.approx(6.0, abs=0.05)
    # Without 1 / sqrt(2), which the minimum-norm argument does not need.
    assert lemma_7_2(gain, SCALING, as_printed=False).unscaled == pytest.approx(8.48, abs=0.01)


def test_largest_attainable_ball_is_larger_than_both_bounds() -> None:
    """The support function of the attainable set over all directions; its minimum is the radius of the largest ball."""
    polar, side = np.meshgrid(np.linspace(0.0, math.pi, 721), np.linspace(0.0, 2.0 * math.pi, 1441))
    u = np.stack([np.sin(polar) * np.cos(side), np.sin(polar) * np.sin(side), np.cos(polar)])
    ahead = u[0] - VESSEL.lever_y[:, None, None] * u[2]
    starboard = u[1] + VESSEL.lever_x[:, None, None] * u[2]
    reach = np.where(SCALING.azimuth_thruster[:, None, None], np.hypot(ahead, starboard), np.abs(starboard))
    radius = (VESSEL.thrust_max[:, None, None] * reach).sum(axis=0).min()
    gain = minimum_gain(scaled_configuration(VESSEL)).gain
    assert lemma_7_2(gain, SCALING).unscaled < lemma_7_2(gain, SCALING, as_printed=False).unscaled < radius
    # Grid of 0.25 deg, tunnel thruster taken as 0.58 N either way.
    assert radius == pytest.approx(12.5, abs=0.1)


@pytest.mark.parametrize(
    ("thrusters", "gain"), [("1234", 1.17), ("234", 0.50), ("134", 1.00), ("124", 0.50), ("123", 0.68)]
)
def test_table_7_1(thrusters: str, gain: float) -> None:
    azimuth = np.radians([0.0, 35.0, -45.0, 45.0])
    B = scaled_configuration(VESSEL, azimuth, enabled(thrusters), equal_thrust=True)
    assert minimum_gain(B).gain == pytest.approx(gain, abs=TABLE_DIGIT)


TABLE_7_2 = [
    ("1234", 3, 1.20, 1.73),
    ("123", 3, 1.17, 1.40),
    ("124", 3, 1.17, 1.40),
    ("134", 3, 0.23, 1.41),
    ("234", 3, 1.19, 1.21),
    ("12", 3, 0.02, 0.20),
    ("13", 3, 0.09, 0.99),
    ("14", 3, 0.09, 0.99),
    ("23", 3, 1.17, 1.19),
    ("24", 3, 1.17, 1.19),
    ("34", 3, 0.22, 0.15),
    ("1", 1, None, None),
    ("2", 2, None, None),
    ("3", 2, None, None),
    ("4", 2, None, None),
]


@pytest.mark.parametrize(("thrusters", "rank", "gain", "gain_equal"), TABLE_7_2)
def test_table_7_2(thrusters: str, rank: int, gain: float | None, gain_equal: float | None) -> None:
    B = scaled_configuration(VESSEL, enabled=enabled(thrusters))
    equal = scaled_configuration(VESSEL, enabled=enabled(thrusters), equal_thrust=True)
    assert np.linalg.matrix_rank(B) == np.linalg.matrix_rank(equal) == rank
    if gain is None:
        assert minimum_gain(B).gain == minimum_gain(equal).gain == 0.0
    else:
        assert minimum_gain(B).gain == pytest.approx(gain, abs=TABLE_DIGIT)
        assert minimum_gain(equal).gain == pytest.approx(gain_equal, abs=TABLE_DIGIT)


@pytest.mark.parametrize(
    ("direction", "angle", "length", "sign"),
    [
        ([0.70, 0.70, 0.14], math.pi / 4, 0.990, 1.0),  # the long red arrow
        ([0.0, -0.1, 0.99], -math.pi / 2, 0.1005, 1.0),  # the short red arrow
        ([-0.57, 0.57, -0.59], 3 * math.pi / 4, 0.807, -1.0),  # the blue arrow; the printed formula gives it length 0
    ],
)
def test_arrows_of_figure_7_14(direction: list[float], angle: float, length: float, sign: float) -> None:
    arrow = project(direction)
    assert arrow.angle == pytest.approx(angle, abs=1e-12)
    assert arrow.length == pytest.approx(length, abs=5e-4)
    assert arrow.yaw_sign == sign
