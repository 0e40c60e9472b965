from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dp_controller.timed_path import TimedPath
from dp_controller.vectors import ZERO
from marine_model.errors import InputError

LEG = [[0.0, 0.0, 0.0], [1.0, 0.5, 0.1], [2.0, 1.0, 0.2], [3.0, 1.5, 0.3], [4.0, 2.0, 0.4]]


def test_poses_are_met_at_their_times() -> None:
    path = TimedPath([0.0, 10.0, 25.0], [[0.0, 0.0, 0.0], [1.0, -2.0, 0.5], [4.0, -2.5, 0.1]])
    assert path.at(0.0)[0] == (0.0, 0.0, 0.0)
    assert path.at(10.0)[0] == pytest.approx((1.0, -2.0, 0.5), abs=1e-15)
    assert path.at(25.0)[0] == pytest.approx((4.0, -2.5, 0.1), abs=1e-15)


def test_first_and_last_pose_are_held_at_rest() -> None:
    path = TimedPath([5.0, 10.0], [[1.0, 2.0, 0.3], [2.0, 2.0, 0.3]])
    assert path.at(-1e6) == ((1.0, 2.0, 0.3), ZERO)
    assert path.at(1e6) == ((2.0, 2.0, 0.3), ZERO)
    # Hand-worked: the cubic from rest to rest, a quarter of the way: u^2 (3 - 2u) = 0.15625, 6 u (1 - u) / 5 = 0.225.
    position, velocity = path.at(6.25)
    assert position == pytest.approx((1.15625, 2.0, 0.3), abs=1e-15)
    assert velocity == pytest.approx((0.225, 0.0, 0.0), abs=1e-15)


def test_constant_velocity_between_inner_poses() -> None:
    path = TimedPath([0.0, 10.0, 20.0, 30.0, 40.0], LEG)
    for time in np.linspace(10.0, 30.0, 41):
        position, velocity = path.at(float(time))
        assert velocity == pytest.approx((0.1, 0.05, 0.01), abs=1e-15)
        assert position == pytest.approx((0.1 * time, 0.05 * time, 0.01 * time), abs=1e-14)


def test_velocity_is_the_derivative_of_position() -> None:
    path = TimedPath([0.0, 3.0, 10.0, 12.0], [[0, 0, 3.0], [1, 2, -3.0], [-1, 2, -2.5], [-1, 3, -1.0]])
    step = 1e-5
    for time in np.linspace(0.1, 11.9, 60):
        ahead, behind = path.at(time + step)[0], path.at(time - step)[0]
        slope = [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
        # Central difference: third derivative of order 1 times step^2, and rounding 1e-16 / step.
        assert path.at(time)[1] == pytest.approx(slope, abs=1e-9)


def test_heading_turns_the_shorter_way_and_may_turn_full_circles() -> None:
    quarter = math.pi / 2
    headings = [quarter * k for k in range(9)]
    wrapped = [math.remainder(h, 2 * math.pi) for h in headings]
    path = TimedPath(np.arange(9.0), [[0.0, 0.0, h] for h in wrapped])
    assert path.at(8.0)[0][2] == pytest.approx(4 * math.pi, abs=1e-12)
    back = TimedPath([0.0, 1.0], [[0.0, 0.0, 3.0], [0.0, 0.0, -3.0]])
    assert back.at(1.0)[0][2] == pytest.approx(2 * math.pi - 3.0, abs=1e-12)


@given(
    st.lists(
        st.tuples(st.floats(0.1, 30), st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3)), min_size=2, max_size=8
    )
)
def test_no_coordinate_leaves_the_interval_between_two_poses(legs: list[tuple[float, float, float, float]]) -> None:
    times = np.cumsum([leg[0] for leg in legs])
    path = TimedPath(times, [leg[1:] for leg in legs])
    speeds = path.body_speeds()
    for begin, end in itertools.pairwise(times):
        a, b = path.at(begin)[0], path.at(end)[0]
        for time in np.linspace(begin, end, 9):
            position, velocity = path.at(float(time))
            for x, low, high in zip(position, map(min, a, b), map(max, a, b), strict=True):
                assert low - 1e-9 <= x <= high + 1e-9  # rounding of sums of numbers up to 50
            c, s = math.cos(position[2]), math.sin(position[2])
            surge = c * velocity[0] + s * velocity[1]
            # body_speeds looks at the same nine points of every segment.
            assert abs(surge) <= speeds[0] + 1e-9


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        ([], np.zeros((0, 3)), "path times: expected shape (k,) with k of at least 1, found (0,)"),
        ([0.0, 1.0], [[0, 0, 0]], "path positions: expected shape (2, 3), found (1, 3)"),
        ([0.0], [[0, 0]], "path positions: expected shape (1, 3), found (1, 2)"),
        ([0.0, math.nan], np.zeros((2, 3)), "path times: expected finite numbers, found nan at pose 1"),
        ([0.0, 1.0], [[0, 0, 0], [0, math.inf, 0]], "found [0.0, inf, 0.0] at pose 1"),
        ([0.0, 2.0, 2.0], np.zeros((3, 3)), "path times: expected them to increase, found 2.0 s after 2.0 s at pose 2"),
        ([0.0, "x"], np.zeros((2, 3)), "path: expected numbers"),
    ],
)
def test_bad_path_is_refused_with_the_reason(times: list[float], positions: list[list[float]], message: str) -> None:
    with pytest.raises(InputError) as caught:
        TimedPath(times, positions)
    assert message in str(caught.value)
