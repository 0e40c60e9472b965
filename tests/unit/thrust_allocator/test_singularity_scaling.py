"""Scaled thruster configuration matrices, [Ruth] 7.1 and 7.5.1."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.thruster_configuration import polar_configuration
from thrust_allocator.singularity import scaled_configuration, scaling_of

VESSEL = load_vessel("cybership3")
SCALING = scaling_of(VESSEL)
angles = st.lists(st.floats(-7.0, 7.0), min_size=4, max_size=4)
masks = st.lists(st.booleans(), min_size=4, max_size=4).map(np.array)


@given(angles, masks)
def test_fixed_columns_are_those_of_7_4(azimuth: list[float], enabled: np.ndarray) -> None:
    angle = np.array(azimuth)
    angle[0] = VESSEL.fixed_direction[0]
    B = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, angle)
    S = np.diag([1.0, 1.0, SCALING.moment_scale])
    whole = S @ B @ np.diag(VESSEL.thrust_max) / SCALING.mean_thrust_max
    # The tunnel's angle as given does not count.
    np.testing.assert_allclose(scaled_configuration(VESSEL, azimuth, enabled), whole[:, enabled], atol=1e-15)


@given(angles, masks, st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_freely_rotating_columns_add_up_to_fixed_ones(azimuth: list[float], enabled: np.ndarray, thrust: list) -> None:
    """A rotating thruster of thrust T is one of T cos(alpha) ahead and one of T sin(alpha) to starboard."""
    T = np.array(thrust)
    components = [T[0]] if enabled[0] else []
    for j in (1, 2, 3):
        if enabled[j]:
            components += [T[j] * np.cos(azimuth[j]), T[j] * np.sin(azimuth[j])]
    rotating = scaled_configuration(VESSEL, enabled=enabled) @ np.array(components)
    np.testing.assert_allclose(rotating, scaled_configuration(VESSEL, azimuth, enabled) @ T[enabled], atol=1e-14)


@given(st.lists(st.floats(-20.0, 20.0), min_size=3, max_size=3))
def test_scaled_force_and_back(tau: list[float]) -> None:
    np.testing.assert_allclose(SCALING.unscaled(SCALING.scaled(tau)), tau, rtol=1e-14, atol=1e-300)
    thrust = [*tau, 1.0]
    np.testing.assert_allclose(SCALING.unscaled_thrust(SCALING.scaled_thrust(thrust)), thrust, rtol=1e-14, atol=1e-300)


def test_scaled_quantities_obey_7_5() -> None:
    azimuth, thrust = np.array([0.0, 0.3, -1.0, 2.0]), np.array([0.2, 3.0, -4.0, 5.0])
    angle = np.where(SCALING.azimuth_thruster, azimuth, VESSEL.fixed_direction)
    tau = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, angle) @ thrust
    B = scaled_configuration(SCALING, azimuth)
    np.testing.assert_allclose(B @ SCALING.scaled_thrust(thrust), SCALING.scaled(tau), atol=1e-15)


def test_equal_thrust_leaves_the_mean() -> None:
    equal = scaling_of(VESSEL, equal_thrust=True)
    assert equal.mean_thrust_max == SCALING.mean_thrust_max
    np.testing.assert_array_equal(equal.thrust_max, np.full(4, equal.mean_thrust_max))
    np.testing.assert_array_equal(scaled_configuration(equal), scaled_configuration(VESSEL, equal_thrust=True))


def test_no_thruster_is_no_column() -> None:
    none = np.zeros(4, dtype=bool)
    assert scaled_configuration(VESSEL, enabled=none).shape == (3, 0)
    assert scaled_configuration(VESSEL, np.zeros(4), none).shape == (3, 0)


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match=r"azimuth: expected shape \(4,\), found \(3,\)"):
        scaled_configuration(VESSEL, [0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="azimuth: expected finite"):
        scaled_configuration(VESSEL, [0.0, np.nan, 0.0, 0.0])
    with pytest.raises(InputError, match="enabled: expected 4 bools, found shape \\(3,\\)"):
        scaled_configuration(VESSEL, enabled=[True, True, False])
    with pytest.raises(InputError, match=r"enabled: expected 4 bools, found .* int64"):
        scaled_configuration(VESSEL, enabled=[1, 1, 0, 1])  # type: ignore[list-item]
    with pytest.raises(InputError, match="equal_thrust: expected False with a scaling"):
        scaled_configuration(SCALING, equal_thrust=True)
