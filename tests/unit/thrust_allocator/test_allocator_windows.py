"""What one step may reach: [Ruth] (4.14)-(4.17)."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from thrust_allocator.plan.windows import step_window


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.0, (-2.0, 2.0)),  # rate limits only
        (9.0, (7.0, 10.0)),  # maximum within reach
        (-3.5, (-4.0, -1.5)),  # minimum within reach
        (10.0, (8.0, 10.0)),
        # Above the maximum by less than c_1 of the rate: straight back to the maximum.
        (11.0, (9.0, 10.0)),
        # By more: back at no less than c_1 of the rate, 13 - 0.9 * 2 = 11.2.
        (13.0, (11.0, 11.2)),
        (-4.5, (-4.0, -2.5)),
        (-9.0, (-7.2, -7.0)),
    ],
)
def test_by_hand_with_limits_minus_4_and_10_and_step_2(value: float, expected: tuple[float, float]) -> None:
    lower, upper = step_window(value, -4.0, 10.0, 2.0, 0.9)
    assert (lower, upper) == pytest.approx(expected)


def test_no_limits_leaves_the_rate() -> None:
    assert step_window(3.0, -math.inf, math.inf, 0.2, 0.9) == (2.8, 3.2)


@given(
    value=st.floats(-1e3, 1e3),
    minimum=st.floats(-100.0, 0.0),
    maximum=st.floats(0.0, 100.0),
    step=st.floats(1e-6, 50.0),
    approach=st.floats(0.0, 0.99),
)
def test_never_empty_and_never_faster_than_the_rate(
    value: float, minimum: float, maximum: float, step: float, approach: float
) -> None:
    lower, upper = step_window(value, minimum, maximum, step, approach)
    assert lower <= upper
    rounding = 1e-12 * (abs(value) + step)
    assert value - step - rounding <= lower
    assert upper <= value + step + rounding
    if value > maximum:  # it comes back, as far as it must or as fast as it may
        assert upper <= max(maximum, value - approach * step) + rounding
    if value < minimum:
        assert lower >= min(minimum, value + approach * step) - rounding
