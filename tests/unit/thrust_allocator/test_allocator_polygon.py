"""Constraints of a rotating thruster in Cartesian coordinates: [Ruth] (4.38)-(4.42), Figure 4.3."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.frames import wrap_angle
from thrust_allocator.plan.polygon import Row, rotating_rows

ANGLES = st.floats(-math.pi, math.pi)
TURNS = st.floats(0.01, math.pi / 3)


def inside(rows: tuple[Row, ...], thrust: float, azimuth: float, tolerance: float = 1e-12) -> bool:
    x, y = thrust * math.cos(azimuth), thrust * math.sin(azimuth)
    return all(a_x * x + a_y * y <= b + tolerance for a_x, a_y, b in rows)


def test_rows_by_hand() -> None:
    # Ahead, 30 deg either way, 2 N to 4 N, c_2 = 0.1: the region is 0.1 * (4 - 2) = 0.2 N wide.
    rows = rotating_rows(0.0, -math.pi / 6, math.pi / 6, 2.0, 4.0, 0.1)
    half, root = 0.5, math.sqrt(3.0) / 2.0
    expected = [
        (-half, -root, 0.2),  # (4.38)
        (-half, root, 0.2),  # (4.39)
        (-1.0, 0.0, -2.0),  # (4.40)
        (root, -half, 4.0 * root),  # (4.41)
        (root, half, 4.0 * root),  # (4.42)
    ]
    np.testing.assert_allclose(rows, expected, atol=1e-15)


@given(azimuth=ANGLES, turn=TURNS, lower=st.floats(0.0, 5.0), width=st.floats(0.1, 5.0))
def test_present_direction_keeps_its_whole_range(azimuth: float, turn: float, lower: float, width: float) -> None:
    rows = rotating_rows(azimuth, -turn, turn, lower, lower + width, 1e-3)
    assert inside(rows, lower, azimuth)
    assert inside(rows, lower + width, azimuth)
    assert not inside(rows, lower - 1e-6, azimuth)
    assert not inside(rows, lower + width + 1e-6, azimuth)


@given(
    azimuth=ANGLES,
    turn=TURNS,
    lower=st.floats(0.0, 5.0),
    width=st.floats(0.1, 5.0),
    x=st.floats(-12.0, 12.0),
    y=st.floats(-12.0, 12.0),
)
def test_lies_within_arcs_and_cone_but_for_the_region_about_zero(
    azimuth: float, turn: float, lower: float, width: float, x: float, y: float
) -> None:
    c2 = 1e-3
    rows = rotating_rows(azimuth, -turn, turn, lower, lower + width, c2)
    thrust, direction = math.hypot(x, y), math.atan2(y, x)
    if not inside(rows, thrust, direction, 0.0):
        return
    off = abs(wrap_angle(direction - azimuth))
    if off <= turn:
        # Rounding of numbers of the size of ten.
        assert lower - 1e-12 <= thrust <= lower + width + 1e-12
    else:
        # Outside the cone by no more than the width of the region.
        beyond = thrust * math.sin(min(off - turn, math.pi / 2))
        assert beyond <= c2 * width + 1e-12


@given(azimuth=ANGLES, turn=TURNS, rotation=ANGLES)
def test_shape_is_the_same_in_every_direction(azimuth: float, turn: float, rotation: float) -> None:
    """As printed, with c_2 |cos(alpha)|, the region about zero would change its width with the direction."""
    rows = np.array(rotating_rows(azimuth, -turn, turn, -0.02, 3.0, 1e-3))
    turned = np.array(rotating_rows(azimuth + rotation, -turn, turn, -0.02, 3.0, 1e-3))
    c, s = math.cos(rotation), math.sin(rotation)
    np.testing.assert_allclose(turned[:, :2], rows[:, :2] @ np.array([[c, s], [-s, c]]), atol=1e-14)
    np.testing.assert_allclose(turned[:, 2], rows[:, 2], atol=1e-14)


@pytest.mark.parametrize("end", [math.pi / 2, -math.pi / 2])
def test_zero_thrust_can_leave_its_cone_where_an_end_is_athwartships(end: float) -> None:
    turn = 0.21
    azimuth = end - turn  # its upper end points to starboard or port
    rows = rotating_rows(azimuth, -turn, turn, -0.02, 3.0, 1e-3)
    b = rows[1][2]
    assert b == pytest.approx(1e-3 * 3.02)  # c_2 |cos(alpha_+)| would make it 2e-19
    # A force just beyond that end is allowed, so that the answer shows which way to turn.
    assert inside(rows, 2.9e-3, end + math.pi / 2)
    assert abs(math.cos(end)) < 1e-15
