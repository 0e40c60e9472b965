"""Efficiency of the controllers beside the best one, [Ruth] 3.4.2, 3.6, Table 3.3."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.propellers import BollardPropeller, WageningenBPropeller
from marine_model.propellers.optimal import advance_number, optimal_pitch
from thruster_drivers.sensitivity.efficiency import (
    Misjudged,
    best_path,
    best_torque_coefficient,
    fixed_pitch,
    least_error_torque_coefficient,
    torque_pitch,
    torque_pitch_from_demand,
    torque_shaft_speed,
)

B4_70 = WageningenBPropeller(4.0, 4, 0.70, 0.58)
TAU = np.linspace(0.0, 6.0, 61)


def test_table_3_3() -> None:
    """Emergent, with the polynomials of 1975, tau 0 to 6; in brackets what is printed, with those of 1969.

    0.7/1.1 (0.7/1.1), 1.0/1.3 (1.6/2.3), 5.0/23.6 (4.5/24), 49/73 (46/73) %.
    """
    assert torque_pitch(B4_70, TAU).relative == pytest.approx(0.011, abs=0.001)
    K_Qc = least_error_torque_coefficient(B4_70, TAU)
    assert K_Qc == pytest.approx(0.0343, abs=1e-4)
    consolidated = torque_shaft_speed(B4_70, TAU, K_Qc)
    assert (consolidated.absolute, consolidated.relative) == pytest.approx((0.0095, 0.0129), abs=5e-4)
    largest = fixed_pitch(B4_70, TAU, 1.4)
    assert (largest.absolute, largest.relative) == pytest.approx((0.0497, 0.236), abs=5e-4)
    design = fixed_pitch(B4_70, TAU, 0.58)
    assert (design.absolute, design.relative) == pytest.approx((0.493, 0.733), abs=5e-4)


def test_no_other_torque_coefficient_errs_less() -> None:
    tau = TAU[:35]  # beyond it all of them have the largest pitch
    K_Qc = least_error_torque_coefficient(B4_70, tau)
    least = torque_shaft_speed(B4_70, tau, K_Qc).relative
    for other in (0.0335, 0.035):
        assert torque_shaft_speed(B4_70, tau, other).relative > least


@settings(max_examples=10)
@given(tau=st.floats(0.0, 8.0), pitch=st.floats(0.5, 1.4))
def test_nothing_is_better_than_the_best(tau: float, pitch: float) -> None:
    path = fixed_pitch(B4_70, np.array([tau]), pitch)
    # The best pitch is that of a spline through 91 points, which differs by 1e-7 of the efficiency at most.
    assert path.relative_error[0] >= -1e-6
    # The advance number is exact to 1e-16, not to so many digits when tau is next to nothing.
    assert path.efficiency[0] <= path.best[0] * (1.0 + 1e-6) + 1e-12
    assert best_path(B4_70, np.array([tau])).relative == 0.0


def test_the_relative_loss_at_rest_is_that_of_the_power() -> None:
    path = fixed_pitch(B4_70, np.array([0.0]), 1.4)
    best = float(optimal_pitch(B4_70, 0.0))
    power = [float(K_Q / K_T**1.5) for K_T, K_Q in (B4_70.coefficients(0.0, p) for p in (best, 1.4))]
    assert path.relative == pytest.approx(1.0 - power[0] / power[1], rel=1e-12)
    assert path.absolute == 0.0


def test_torque_shaft_speed_holds_its_torque_coefficient_or_saturates() -> None:
    path = torque_shaft_speed(B4_70, TAU, 0.033)
    _, K_Q = B4_70.coefficients(advance_number(B4_70, TAU, path.pitch_ratio), path.pitch_ratio)
    free = path.pitch_ratio < 1.4
    assert 10 < free.sum() < len(TAU)
    # Two searches, one in the other: 2e-9 measured.
    np.testing.assert_allclose(K_Q[free], 0.033, rtol=1e-8)
    assert np.all(K_Q[~free] < 0.033)
    assert float(torque_shaft_speed(B4_70, np.array([0.0]), 0.001).pitch_ratio[0]) == 0.5


def test_a_misjudged_model_is_as_good_as_its_pitch() -> None:
    right = Misjudged(1.0, 1.0, 1.0)
    assert torque_pitch(B4_70, TAU, right).relative == 0.0
    # Only the product f_V sqrt(f_T) counts, and K_Q not at all.
    one, other = Misjudged(0.81, 1.0, 1.0), Misjudged(1.0, 1.3, 0.9)
    np.testing.assert_allclose(torque_pitch(B4_70, TAU, one).pitch_ratio, torque_pitch(B4_70, TAU, other).pitch_ratio)


def test_without_errors_demanded_thrust_is_given() -> None:
    path = torque_pitch_from_demand(B4_70, TAU, Misjudged(1.0, 1.0, 1.0))
    np.testing.assert_allclose(path.loading, TAU, rtol=1e-9, atol=1e-12)
    assert path.relative < 1e-9


def test_too_much_torque_gives_a_lower_tau_than_asked() -> None:
    path = torque_pitch_from_demand(B4_70, TAU[:30])
    assert np.all(path.loading[1:] < TAU[1:30])
    assert path.relative > torque_pitch(B4_70, TAU).relative
    assert path.up_to(1.0).loading.max() <= 1.0


def test_best_torque_coefficient() -> None:
    """0.0226 at rest in the thesis, with P/D 0.58; here 0.0245 with P/D 0.597."""
    K_Q = best_torque_coefficient(B4_70, np.array([0.0, 6.0]))
    assert K_Q[0] == pytest.approx(0.0245, abs=1e-4)
    J = advance_number(B4_70, 6.0, 1.4)
    assert K_Q[1] == pytest.approx(float(B4_70.coefficients(J, 1.4)[1]), rel=1e-12)


def test_a_range_of_pitch_is_kept() -> None:
    for path in (
        best_path(B4_70, TAU, (0.6, 1.0)),
        torque_shaft_speed(B4_70, TAU, 0.03, (0.6, 1.0)),
        torque_pitch(B4_70, TAU, None, (0.6, 1.0)),
    ):
        assert path.pitch_ratio.min() >= 0.6
        assert path.pitch_ratio.max() <= 1.0


def test_refusals() -> None:
    with pytest.raises(InputError, match="found one pitch"):
        best_path(BollardPropeller(1.0, 1.0, 0.4, 0.05, -0.4, -0.03), TAU)
    with pytest.raises(InputError, match="controllable pitch"):
        least_error_torque_coefficient(BollardPropeller(1.0, 1.0, 0.4, 0.05, -0.4, -0.03), TAU)
    with pytest.raises(InputError, match="thrust_coefficient: expected a number above 0"):
        Misjudged(thrust_coefficient=0.0)
    with pytest.raises(InputError, match="torque_coefficient: expected a number above 0"):
        torque_shaft_speed(B4_70, TAU, -0.1)
