"""Angles, rotations and quaternions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.frames import (
    attitude_rotation,
    attitude_to_quaternion,
    heading_to_quaternion,
    quaternion_to_attitude,
    quaternion_to_heading,
    rotation,
    wrap_angle,
    wrap_angles,
)

angles = st.floats(-1e6, 1e6)


@given(angle=angles)
def test_wrapped_angle_is_the_same_direction(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    # Rounding of angles up to 1e6.
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(values=st.lists(angles, min_size=1, max_size=10))
def test_arrays_wrap_as_numbers_do(values: list[float]) -> None:
    np.testing.assert_array_equal(wrap_angles(np.array(values)), [wrap_angle(v) for v in values])


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(math.pi, -math.pi), (-math.pi, -math.pi), (3 * math.pi, -math.pi), (0.0, 0.0), (-1e-17, 0.0)],
)
def test_edges(angle: float, wrapped: float) -> None:
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-15)
    assert wrap_angle(math.nextafter(-math.pi, -10.0)) < math.pi


def test_what_is_no_angle_stays_none() -> None:
    assert math.isnan(wrap_angle(math.nan))
    np.testing.assert_array_equal(wrap_angles(np.array([math.nan, 4.0 * math.pi])), [math.nan, 0.0])


def test_rotation_turns_ahead_into_the_heading() -> None:
    """Heading east: ahead is east, starboard is south."""
    turn = rotation(math.pi / 2)
    np.testing.assert_allclose(turn @ [1.0, 0.0, 0.3], [0.0, 1.0, 0.3], atol=1e-16)
    np.testing.assert_allclose(turn @ [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], atol=1e-16)


@given(a=st.floats(-10, 10), b=st.floats(-10, 10))
def test_rotations_are_orthogonal_and_add(a: float, b: float) -> None:
    np.testing.assert_allclose(rotation(a) @ rotation(a).T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(rotation(a) @ rotation(b), rotation(a + b), atol=1e-14)


@given(heading=st.floats(-math.pi, math.pi), size=st.floats(0.991, 1.009), sign=st.sampled_from([-1.0, 1.0]))
def test_heading_survives_a_quaternion_of_either_sign_and_nearly_unit_length(
    heading: float, size: float, sign: float
) -> None:
    x, y, z, w = (sign * size * part for part in heading_to_quaternion(heading))
    # The square root of the rounding, where both components of the arc tangent are of order one: 1e-15.
    assert abs(wrap_angle(quaternion_to_heading(x, y, z, w) - heading)) < 1e-14


def test_heading_is_that_of_a_rolling_and_pitching_vessel() -> None:
    """z-y-x sequence: yaw 0.7, pitch 0.2, roll -0.3, composed by hand."""

    def product(p: tuple[float, ...], q: tuple[float, ...]) -> tuple[float, ...]:
        (a, b, c, d), (e, f, g, h) = p, q  # w, x, y, z
        return (
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        )

    def about(axis: int, angle: float) -> tuple[float, ...]:
        parts = [math.cos(angle / 2), 0.0, 0.0, 0.0]
        parts[axis] = math.sin(angle / 2)
        return tuple(parts)

    w, x, y, z = product(product(about(3, 0.7), about(2, 0.2)), about(1, -0.3))
    assert quaternion_to_heading(x, y, z, w) == pytest.approx(0.7, abs=1e-15)


@pytest.mark.parametrize(
    "bad", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.02), (math.nan, 0.0, 0.0, 1.0), (0.0, math.inf, 0.0, 1.0)]
)
def test_what_is_no_orientation_is_refused(bad: tuple[float, float, float, float]) -> None:
    with pytest.raises(InputError, match="orientation: expected a unit quaternion, found"):
        quaternion_to_heading(*bad)


def test_attitude_turns_about_heading_then_pitch_then_roll() -> None:
    """Bow up raises the bow, starboard down lowers the starboard side, and the order is z-y-x."""
    np.testing.assert_array_equal(attitude_rotation(0.0, 0.0, 0.7), rotation(0.7))
    np.testing.assert_allclose(attitude_rotation(0.0, 0.3, 0.0) @ [1, 0, 0], [math.cos(0.3), 0, -math.sin(0.3)])
    np.testing.assert_allclose(attitude_rotation(0.3, 0.0, 0.0) @ [0, 1, 0], [0, math.cos(0.3), math.sin(0.3)])
    turns = attitude_rotation(0, 0, 0.7) @ attitude_rotation(0, 0.2, 0) @ attitude_rotation(-0.3, 0, 0)
    np.testing.assert_allclose(attitude_rotation(-0.3, 0.2, 0.7), turns, atol=1e-15)


@given(roll=st.floats(-3.1, 3.1), pitch=st.floats(-1.5, 1.5), heading=st.floats(-3.1, 3.1))
def test_attitude_survives_a_quaternion(roll: float, pitch: float, heading: float) -> None:
    quaternion = attitude_to_quaternion(roll, pitch, heading)
    # Near the singularity, cos 1.5 = 0.07, rounding counts 14-fold.
    np.testing.assert_allclose(quaternion_to_attitude(*quaternion), (roll, pitch, heading), atol=1e-13)
    x, y, z, w = quaternion
    turn = attitude_rotation(roll, pitch, heading)
    # The rotation that the quaternion stands for: its third row and first column.
    np.testing.assert_allclose(turn[2], [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], atol=1e-14)
    np.testing.assert_allclose(
        turn[:, 0], [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], atol=1e-14
    )


@given(heading=st.floats(-math.pi, math.pi))
def test_attitude_of_a_heading_alone_is_that_of_the_heading_to_the_bit(heading: float) -> None:
    assert attitude_to_quaternion(0.0, 0.0, heading) == heading_to_quaternion(heading)


def test_bow_straight_up_is_no_error() -> None:
    roll, pitch, heading = quaternion_to_attitude(*attitude_to_quaternion(0.0, math.pi / 2, 0.4))
    # The root of the rounding is what is left of cos(pitch).
    assert pitch == pytest.approx(math.pi / 2, abs=1e-7)
    assert math.isfinite(roll)
    assert math.isfinite(heading)
