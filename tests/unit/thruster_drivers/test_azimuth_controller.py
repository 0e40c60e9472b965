"""[Ruth] (B.37)-(B.38), with the condition on |alpha~|."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.gains import AzimuthGains
from thruster_drivers.azimuth import AzimuthController

# One step a rad/s, so that the rate is the printed number of steps.
STEPS = AzimuthGains(quadratic_gain=689.0, linear_gain=40.1, threshold=0.058, rate_per_step=1.0)
LAW = AzimuthController(STEPS, rate_max=1000.0)


@pytest.mark.parametrize(
    ("error", "steps"),
    [
        (0.0, 0.0),
        (0.02, 0.2756),  # 689 * 0.02^2
        (0.0579, 2.30981),  # 689 * 0.0579^2: just below
        (0.058, 2.3258),  # 40.1 * 0.058: at the threshold, where the quadratic branch would say 2.317796
        (0.0581, 2.32981),  # 40.1 * 0.0581: just above
        (0.2, 8.02),
        (math.pi / 2, 62.98893),
    ],
)
def test_values_by_hand_for_either_sign(error: float, steps: float) -> None:
    # The hand values carry five decimals.
    assert LAW.rate(error, 0.0) == pytest.approx(steps, abs=1e-5)
    # As printed, "alpha~ <= 0.058" would send -0.2 through the quadratic branch: -27.56 steps.
    assert LAW.rate(-error, 0.0) == pytest.approx(-steps, abs=1e-5)


@given(st.floats(-math.pi + 1e-6, math.pi - 1e-6), st.floats(-3.0, 3.0))
def test_odd_in_the_error_and_blind_to_whole_turns(error: float, measured: float) -> None:
    rate = LAW.rate(measured + error, measured)
    # The sum's rounding times the steepest slope of the law, 689 * 2 * 0.058 steps/rad; the law itself steps by
    # 0.008 at the threshold.
    slack = 1e-9 + (0.0081 if abs(abs(error) - 0.058) < 1e-9 else 0.0)
    assert LAW.rate(measured - error, measured) == pytest.approx(-rate, abs=slack)
    assert LAW.rate(measured + error + 2.0 * math.pi, measured) == pytest.approx(rate, abs=slack)


@pytest.mark.parametrize(
    ("commanded", "measured", "way"), [(-3.1, 3.1, 0.0831853), (3.1, -3.1, -0.0831853), (0.0, 2.0 * math.pi - 0.3, 0.3)]
)
def test_takes_the_short_way_across_pi(commanded: float, measured: float, way: float) -> None:
    assert LAW.rate(commanded, measured) == pytest.approx(40.1 * way, abs=1e-5)  # the angles carry seven decimals


def test_rate_per_step_and_motor_limit() -> None:
    gains = STEPS.model_copy(update={"rate_per_step": 0.1247})
    law = AzimuthController(gains, rate_max=1.05)
    assert law.rate(0.1, 0.0) == pytest.approx(40.1 * 0.1 * 0.1247)
    assert law.rate(3.0, 0.0) == 1.05
    assert law.rate(-3.0, 0.0) == -1.05


@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf])
def test_lost_measurement_stops_the_motor(lost: float) -> None:
    assert LAW.rate(1.0, lost) == 0.0
