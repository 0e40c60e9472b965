"""Degrees of freedom by name, and the thruster configuration matrix over any of them, [Ruth] (4.3)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.axes import AXES, axis_indices, in_six
from marine_model.errors import InputError
from marine_model.thruster_configuration import polar_configuration, thruster_columns


def columns_of(name: str) -> np.ndarray:
    """B over the vessel's axes with every thruster in its fixed direction, shape (m, n)."""
    vessel = load_vessel(name)
    ahead = np.column_stack([np.cos(vessel.fixed_direction), np.sin(vessel.fixed_direction)])
    return np.einsum("nmk,nk->mn", vessel.columns, ahead)


def test_axes_stand_in_their_order() -> None:
    assert axis_indices(("surge", "sway", "yaw")).tolist() == [0, 1, 5]
    assert in_six(("heave", "pitch"), np.array([2.0, -3.0])).tolist() == [0.0, 0.0, 2.0, 0.0, -3.0, 0.0]
    with pytest.raises(InputError, match="axis: expected one of surge, sway, heave, roll, pitch, yaw, found 'trim'"):
        axis_indices(("surge", "trim"))


def test_a_horizontal_thruster_has_the_columns_of_three_degrees_of_freedom() -> None:
    vessel = load_vessel("cybership3")
    azimuth = np.array([0.3, -1.1, 2.0, 0.7])
    full = np.einsum("nmk,kn->mn", vessel.columns6, np.array([np.cos(azimuth), np.sin(azimuth)]))
    expected = polar_configuration(vessel.lever_x, vessel.lever_y, azimuth)
    # Sums of two products of numbers below 1, in another order.
    assert np.allclose(full[[0, 1, 5]], expected, rtol=0.0, atol=1e-15)
    # A force at depth z rolls and pitches: r x F = (-z F_y, z F_x, .).
    depth = np.array([thruster.position[2] for thruster in vessel.thrusters])
    assert np.allclose(full[3], -depth * np.sin(azimuth), rtol=0.0, atol=1e-15)
    assert np.allclose(full[4], depth * np.cos(azimuth), rtol=0.0, atol=1e-15)


def test_the_moment_is_the_cross_product() -> None:
    rng = np.random.default_rng(5)
    position, plane = rng.normal(size=(7, 3)), rng.normal(size=(7, 2, 3))
    columns = thruster_columns(position, plane)
    for j in range(7):
        for k in range(2):
            expected = np.concatenate([plane[j, k], np.cross(position[j], plane[j, k])])
            assert np.array_equal(columns[j, :, k], expected)


def test_ukwial_has_the_largest_forces_of_the_paper() -> None:
    # Garus (2005) prints 875 N and 485 N, rounded, and 332 N m, which is 329.65 N m from its own angles.
    largest = np.abs(columns_of("ukwial")) @ load_vessel("ukwial").thrust_max
    assert largest[[0, 1]] == pytest.approx([875.0, 485.0], abs=0.5)
    assert largest[3] == pytest.approx(250.0 * 4.0 * 0.4 * math.sin(math.radians(55.5)), rel=1e-12)
    assert largest[3] == pytest.approx(329.65, abs=0.01)


def test_mmt300_has_the_forces_of_the_paper() -> None:
    """(5) of Kostenko (2023), in x ahead, y up, z to starboard; here heave is down, yaw about the axis down."""
    vessel = load_vessel("mmt300")
    assert vessel.thruster_names == ("upper", "lower", "left", "right", "bow_vertical")
    up, down, left, right, bow = np.eye(5)
    delta, arm, bow_arm = math.radians(22.5), -vessel.thrusters[0].position[0], vessel.thrusters[4].position[0]
    expected = np.array(
        [
            (up + down + left + right) * math.cos(delta),
            -((up - down) * math.sin(delta) + bow),
            bow * bow_arm - (up - down) * math.sin(delta) * arm,
            -(right - left) * math.sin(delta) * arm,
        ]
    )
    # Directions are written with twelve digits.
    assert np.allclose(columns_of("mmt300"), expected, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("name", ["ukwial", "ukwial_azimuth", "mmt300"])
def test_a_submerged_vehicle_has_its_own_axes_and_no_surface(name: str) -> None:
    vessel = load_vessel(name)
    assert vessel.is_submerged
    assert list(vessel.degrees_of_freedom) == [axis for axis in AXES if axis in vessel.degrees_of_freedom]
    assert vessel.columns.shape == (len(vessel.thrusters), len(vessel.degrees_of_freedom), 2)
    with pytest.raises(InputError, match=f"expected one on the surface, found '{name}', which is submerged"):
        vessel.on_surface()
