"""The azimuth servo against the closed solution of a first-order lag."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vessel_sim.propulsion.azimuth_servo import advance, settled_share


def turn(
    angle: float, rate: float, demand: float, rate_max: float, time_constant: float, dt: float
) -> tuple[float, float]:
    return advance(angle, rate, demand, rate_max, time_constant, settled_share(time_constant, dt), dt)


def test_step_response() -> None:
    # One time constant after a step to 1 rad/s the rate is 1 - 1/e, the angle T/e.
    angle, rate = turn(0.0, 0.0, 1.0, 2.0, 0.05, 0.05)
    assert rate == pytest.approx(1.0 - math.exp(-1.0), rel=1e-12)
    assert angle == pytest.approx(0.05 * math.exp(-1.0), rel=1e-12)


@given(
    rate=st.floats(-1.0, 1.0),
    demand=st.floats(-10.0, 10.0),
    dt=st.floats(1e-3, 1.0),
    part=st.floats(0.01, 0.99),
)
def test_two_steps_are_one_step(rate: float, demand: float, dt: float, part: float) -> None:
    halfway = turn(0.3, rate, demand, 1.0, 0.05, part * dt)
    twice = turn(*halfway, demand, 1.0, 0.05, (1.0 - part) * dt)
    once = turn(0.3, rate, demand, 1.0, 0.05, dt)
    assert twice == pytest.approx(once, rel=1e-9, abs=1e-12)  # rounding


@given(demands=st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=30))
def test_rate_limit_holds(demands: list[float]) -> None:
    angle = rate = 0.0
    for demand in demands:
        before = angle
        angle, rate = turn(angle, rate, demand, 1.05, 0.05, 0.02)
        assert abs(rate) <= 1.05 * (1.0 + 1e-12)
        assert abs(angle - before) <= 1.05 * 0.02 * (1.0 + 1e-12)
