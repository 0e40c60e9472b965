"""The thruster configuration matrix: (4.24) by hand, and both forms against each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import cartesian_configuration, generalized_force, polar_configuration

BY_HAND = {
    "cybership3": [
        [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        [0.0, 0.0, 0.11, -0.11, 0.84, 0.76, -0.81, -0.81],
    ],
    "cybership3_ch7": [
        [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        [0.0, 0.0, 0.1225, -0.1225, 0.85, 0.55, -0.875, -0.875],
    ],
}


@pytest.mark.parametrize("name", BY_HAND)
def test_cartesian_form_is_4_24(name: str) -> None:
    """[Ruth] (4.24): rows of ones, and -L_y beside L_x."""
    vessel = load_vessel(name)
    np.testing.assert_array_equal(cartesian_configuration(vessel.lever_x, vessel.lever_y), BY_HAND[name])


def test_moments_turn_the_way_the_frames_say() -> None:
    """Yaw is positive bow to starboard: thrust to starboard at the bow, or ahead on the port side."""
    bow, port = (np.array([1.0]), np.array([0.0])), (np.array([0.0]), np.array([-1.0]))
    one, starboard, ahead = np.array([1.0]), np.array([np.pi / 2]), np.array([0.0])
    # cos(pi/2) is 6e-17.
    np.testing.assert_allclose(generalized_force(*bow, one, starboard), [0.0, 1.0, 1.0], atol=1e-16)
    np.testing.assert_allclose(generalized_force(*port, one, ahead), [1.0, 0.0, 1.0], atol=1e-16)


def test_fixed_directions_of_cybership3_by_hand() -> None:
    """Thrusters at 90, 90, 45 and -45 deg: sums of sines and cosines written out."""
    vessel = load_vessel("cybership3")
    half = np.sqrt(0.5)
    expected = [
        [0.0, 0.0, half, half],
        [1.0, 1.0, half, -half],
        [0.84, 0.76, half * (-0.81 + 0.11), half * (0.81 - 0.11)],
    ]
    found = polar_configuration(vessel.lever_x, vessel.lever_y, vessel.fixed_direction)
    np.testing.assert_allclose(found, expected, atol=1e-15)


arms = st.floats(-100.0, 100.0)
row = st.tuples(arms, arms, st.floats(-1e4, 1e4), st.floats(-10.0, 10.0))


@given(rows=st.lists(row, min_size=1, max_size=12))
def test_polar_and_cartesian_forms_agree(rows: list[tuple[float, ...]]) -> None:
    lever_x, lever_y, thrust, azimuth = (np.array(column) for column in zip(*rows, strict=True))
    components = np.concatenate([thrust * np.cos(azimuth), thrust * np.sin(azimuth)])
    cartesian = cartesian_configuration(lever_x, lever_y) @ components
    polar = polar_configuration(lever_x, lever_y, azimuth) @ thrust
    direct = generalized_force(lever_x, lever_y, thrust, azimuth)
    # Sums of at most 24 products of at most 1e6: rounding of 24 * 1e6 * 1e-16.
    np.testing.assert_allclose(polar, cartesian, rtol=1e-12, atol=1e-8)
    np.testing.assert_allclose(direct, cartesian, rtol=1e-12, atol=1e-8)


@pytest.mark.parametrize("name", BY_HAND)
@given(
    thrust=st.tuples(*[st.floats(-13.0, 13.0)] * 4),
    azimuth=st.tuples(*[st.floats(-np.pi, np.pi)] * 4),
)
def test_shipped_vessels_in_both_forms(name: str, thrust: tuple[float, ...], azimuth: tuple[float, ...]) -> None:
    vessel = load_vessel(name)
    t, a = np.array(thrust), np.array(azimuth)
    components = np.concatenate([t * np.cos(a), t * np.sin(a)])
    expected = np.array(BY_HAND[name]) @ components
    np.testing.assert_allclose(polar_configuration(vessel.lever_x, vessel.lever_y, a) @ t, expected, atol=1e-13)


@given(rows=st.lists(row, min_size=1, max_size=6), angle=st.floats(-np.pi, np.pi))
def test_moving_the_origin_moves_the_moment_only(rows: list[tuple[float, ...]], angle: float) -> None:
    """Mechanics: about another point the force is the same and the moment changes by lever times force."""
    lever_x, lever_y, thrust, azimuth = (np.array(column) for column in zip(*rows, strict=True))
    shift: FloatArray = np.array([np.cos(angle), np.sin(angle)])
    here = generalized_force(lever_x, lever_y, thrust, azimuth)
    there = generalized_force(lever_x - shift[0], lever_y - shift[1], thrust, azimuth)
    np.testing.assert_allclose(there[:2], here[:2], rtol=1e-12, atol=1e-9)
    moment = here[2] - (shift[0] * here[1] - shift[1] * here[0])
    np.testing.assert_allclose(there[2], moment, rtol=1e-9, atol=1e-7)
