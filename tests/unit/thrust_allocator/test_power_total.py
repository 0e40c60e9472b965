"""Total power, [Ruth] (4.43)-(4.49)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from marine_model import load_vessel
from thrust_allocator.power import (
    CorrectionSource,
    full_power,
    measured_correction,
    phase_back,
    phase_back_factor,
    total_power,
)

VESSEL = load_vessel("cybership3")
M = VESSEL.propellers.power_per_thrust_3_2
ALL = np.ones(4)


def test_total_by_hand() -> None:
    assert total_power(np.array([2.0, 0.5]), np.array([-4.0, 9.0])) == pytest.approx(2.0 * 8.0 + 0.5 * 27.0)


def test_total_is_that_of_the_propellers() -> None:
    thrust = np.array([-0.3, 4.0, -7.0, 12.0])
    assert total_power(M, thrust) == pytest.approx(float(VESSEL.propellers.power(thrust).sum()), rel=1e-14)
    larger = np.array([0.58, 8.7, 13.5, 13.0])
    assert full_power(M, VESSEL.thrust_min, VESSEL.thrust_max) == total_power(M, larger)


@pytest.mark.parametrize(
    ("measured", "before", "age", "factor", "source"),
    [
        (12.0, 10.0, 0.2, 1.2, CorrectionSource.MEASURED),
        (8.0, 10.0, 0.0, 0.8, CorrectionSource.MEASURED),
        (0.0, 10.0, 0.2, 0.5, CorrectionSource.CLAMPED),
        (90.0, 10.0, 0.2, 2.0, CorrectionSource.CLAMPED),
        (None, 10.0, 0.2, 1.0, CorrectionSource.NO_MEASUREMENT),
        (math.nan, 10.0, 0.2, 1.0, CorrectionSource.NO_MEASUREMENT),
        (math.inf, 10.0, 0.2, 1.0, CorrectionSource.NO_MEASUREMENT),
        (-3.0, 10.0, 0.2, 1.0, CorrectionSource.NO_MEASUREMENT),
        (12.0, 10.0, 1.2, 1.0, CorrectionSource.NO_MEASUREMENT),
        (12.0, 10.0, -0.1, 1.0, CorrectionSource.NO_MEASUREMENT),
        (12.0, 10.0, math.nan, 1.0, CorrectionSource.NO_MEASUREMENT),
        (12.0, 0.0, 0.2, 1.0, CorrectionSource.NO_REFERENCE),
        (0.0, 0.0, 0.2, 1.0, CorrectionSource.NO_REFERENCE),
        (12.0, 0.9, 0.2, 1.0, CorrectionSource.NO_REFERENCE),  # below a hundredth of full power
        (12.0, math.nan, 0.2, 1.0, CorrectionSource.NO_REFERENCE),
    ],
)
def test_correction(measured, before, age, factor, source) -> None:
    found = measured_correction(measured, before, age, 1.0, 100.0)
    assert found.factor == pytest.approx(factor)
    assert found.source is source


def test_u_by_hand() -> None:
    # (4.49): an eighth of the power is a quarter of the thrust.
    assert phase_back_factor(10.0, 80.0) == pytest.approx(0.25)
    assert phase_back_factor(80.0, 80.0) == 1.0
    assert phase_back_factor(90.0, 80.0) == 1.0
    assert phase_back_factor(0.0, 80.0) == 0.0
    assert phase_back_factor(-1.0, 80.0) == 0.0
    assert phase_back_factor(0.0, 0.0) == 1.0
    assert phase_back_factor(math.inf, 80.0) == 1.0


thrusts = st.tuples(
    *(st.floats(float(low), float(high)) for low, high in zip(VESSEL.thrust_min, VESSEL.thrust_max, strict=True))
).map(np.array)


@given(thrust=thrusts, available=st.floats(0.0, 60.0))
def test_phase_back_without_windows_is_4_49(thrust: np.ndarray, available: float) -> None:
    out = np.empty(4)
    u = phase_back(M, ALL, thrust, np.full(4, -np.inf), np.full(4, np.inf), available, out)
    power = total_power(M, thrust)
    assert u == pytest.approx(phase_back_factor(available, power), abs=1e-12)
    np.testing.assert_allclose(out, u * thrust, atol=1e-15)
    assert total_power(M, out) <= available * (1.0 + 1e-12) + 1e-300
    # The generalized force keeps its direction: (4.46).


@given(
    thrust=thrusts,
    below=arrays(np.float64, 4, elements=st.floats(0.0, 10.0)),
    above=arrays(np.float64, 4, elements=st.floats(0.0, 10.0)),
    member=arrays(np.float64, 4, elements=st.sampled_from([0.0, 1.0])),
    available=st.floats(0.0, 60.0),
)
def test_phase_back_within_windows(thrust, below, above, member, available) -> None:
    lower, upper = thrust - below, thrust + above
    out = np.empty(4)
    u = phase_back(M, member, thrust, lower, upper, available, out)
    assert 0.0 <= u <= 1.0
    rounding = 1e-14 * np.abs(thrust)
    assert (out >= lower - rounding).all()
    assert (out <= upper + rounding).all()
    assert (out[member == 0.0] == thrust[member == 0.0]).all()
    assert (np.abs(out) <= np.abs(thrust) + rounding).all()
    mine = member * M
    # The least power that scaling towards zero can reach in this step.
    least = total_power(mine, np.clip(np.zeros(4), np.minimum(lower, thrust), np.maximum(upper, thrust)))
    asked = total_power(mine, thrust)
    if asked <= available:
        assert u == 1.0
    elif least >= available:
        assert total_power(mine, out) == pytest.approx(least, rel=1e-9, abs=1e-12)
    else:
        # All of what there is is used, no more: exact, by fixing one thruster after the other.
        assert total_power(mine, out) == pytest.approx(available, rel=1e-9, abs=1e-12)


def test_the_thrust_that_cannot_fall_is_made_up_for_by_the_others() -> None:
    # Powers 8 and 8, 10 available; the first may fall to 0.9 of its thrust only.
    out = np.empty(2)
    held = 8.0 * 0.9**1.5
    thrust = np.array([4.0, -4.0])
    u = phase_back(np.ones(2), np.ones(2), thrust, np.array([3.6, -5.0]), np.array([5.0, 5.0]), 10.0, out)
    assert u == pytest.approx(((10.0 - held) / 8.0) ** (2.0 / 3.0))
    np.testing.assert_allclose(out, [3.6, -4.0 * u])


def test_out_may_be_the_thrust_itself() -> None:
    thrust = np.array([1.0, 4.0])
    phase_back(np.ones(2), np.ones(2), thrust, np.full(2, -9.0), np.full(2, 9.0), 0.0, thrust)
    np.testing.assert_array_equal(thrust, [0.0, 0.0])
