"""The pitch actuator against hand-worked cases, its own composition and a numerical integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vessel_sim.propulsion.pitch_servo import advance

LOW, HIGH, RATE, LAG = -0.6, 1.2, 0.2, 0.5  # so that the rate limit holds beyond an error of 0.1

pitches = st.floats(LOW, HIGH)
demands = st.floats(-3.0, 3.0)
durations = st.floats(1e-3, 20.0)


def turn(pitch: float, demand: float, dt: float) -> float:
    return advance(pitch, demand, LOW, HIGH, RATE, LAG, dt)


def test_small_steps_are_a_first_order_lag() -> None:
    assert turn(0.8, 0.88, LAG) == pytest.approx(0.88 - 0.08 * math.exp(-1.0), rel=1e-12)


def test_large_steps_go_at_the_rate_limit_first() -> None:
    # From 0 to 0.5: 0.4 at 0.2 a second, then an error of 0.1 that decays.
    assert turn(0.0, 0.5, 1.0) == pytest.approx(0.2, rel=1e-12)
    assert turn(0.0, 0.5, 2.0) == pytest.approx(0.4, rel=1e-12)
    assert turn(0.0, 0.5, 2.5) == pytest.approx(0.5 - 0.1 * math.exp(-1.0), rel=1e-12)


@given(pitch=pitches, demand=demands, dt=durations)
def test_range_and_rate_hold_and_nothing_overshoots(pitch: float, demand: float, dt: float) -> None:
    after = turn(pitch, demand, dt)
    assert LOW <= after <= HIGH
    assert abs(after - pitch) <= RATE * dt * (1.0 + 1e-12) + 1e-15  # rounding
    target = min(max(demand, LOW), HIGH)
    assert abs(target - after) <= abs(target - pitch)
    assert (target - after) * (target - pitch) >= 0.0


@given(pitch=pitches, demand=demands, dt=durations, part=st.floats(0.01, 0.99))
def test_two_steps_are_one_step(pitch: float, demand: float, dt: float, part: float) -> None:
    twice = turn(turn(pitch, demand, part * dt), demand, (1.0 - part) * dt)
    assert twice == pytest.approx(turn(pitch, demand, dt), rel=1e-12, abs=1e-14)  # rounding


@pytest.mark.parametrize(("pitch", "demand", "dt"), [(0.0, 0.9, 3.0), (1.1, -0.4, 9.0), (0.5, 0.45, 0.3)])
def test_against_numerical_integration(pitch: float, demand: float, dt: float) -> None:
    def rate(_: float, p: np.ndarray) -> np.ndarray:
        return np.clip((demand - p) / LAG, -RATE, RATE)

    expected = solve_ivp(rate, (0.0, dt), [pitch], rtol=1e-10, atol=1e-12, max_step=0.05).y[0, -1]
    # The kink at the end of the saturated phase costs the integrator some digits.
    assert turn(pitch, demand, dt) == pytest.approx(float(expected), abs=1e-7)
