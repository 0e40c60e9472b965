"""The best pitch of the Wageningen B4-70, beside [Ruth]'s figures for it from the polynomials of 1969."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers import BollardPropeller, TabulatedPropeller, WageningenBPropeller
from marine_model.propellers.optimal import (
    TAU_MAX,
    OptimalMaps,
    advance_number,
    efficiency,
    optimal_maps,
    optimal_pitch,
    pitch_of_thrust_coefficient,
    pitch_of_torque_coefficient,
    thrust_pitches,
)

B4_70 = WageningenBPropeller(diameter=4.0, blades=4, area_ratio=0.7, pitch_ratio=0.58)
MAPS = optimal_maps(B4_70)


@given(st.floats(0.0, TAU_MAX), st.floats(0.5, 1.4))
def test_advance_number_solves_for_tau(tau: float, pitch: float) -> None:
    J = float(advance_number(B4_70, tau, pitch))
    K_T, _ = B4_70.coefficients(J, pitch)
    # J is found to rounding.
    assert pytest.approx(tau * math.sqrt(K_T), abs=1e-9) == J


@pytest.mark.parametrize("tau", [0.0, 0.4, 1.0, 1.7, 2.3, 3.5, 6.0])
def test_no_pitch_needs_less_power_than_the_best_one(tau: float) -> None:
    """Against scipy's own search, one pitch ratio at a time."""

    def cost(pitch: float) -> float:
        K_T, K_Q = B4_70.coefficients(_advance_number(tau, pitch), pitch)
        return float(K_Q / K_T**1.5)

    found = float(optimal_pitch(B4_70, tau))
    low, high = max(0.5, found - 0.1), min(1.4, found + 0.1)
    nearby = minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
    # The cubic spline through 46 pitch ratios is within 1e-9 of the cost.
    assert cost(found) <= nearby.fun * (1.0 + 1e-9)
    assert cost(found) <= min(cost(pitch) for pitch in np.linspace(0.5, 1.4, 91)) * (1.0 + 1e-9)


def _advance_number(tau: float, pitch: float) -> float:
    end = float(B4_70.advance_number_end(pitch))
    if tau == 0.0:
        return 0.0
    return float(brentq(lambda J: J - tau * math.sqrt(max(float(B4_70.coefficients(J, pitch)[0]), 0.0)), 0.0, end))


def test_maps_agree_with_what_they_are_made_of() -> None:
    tau = np.linspace(0.0, 6.0, 241) + 0.0031  # between the points of the maps
    best = optimal_pitch(B4_70, tau)
    K_T, K_Q = B4_70.coefficients(advance_number(B4_70, tau, best), best)
    # At the jump from one optimum to the other, at tau 2.04, two steps of a map are between the two.
    away = np.abs(tau - 2.04) > 0.05
    for found, exact in (
        (MAPS.pitch_ratio(tau), best),
        (MAPS.torque_coefficient(tau), K_Q),
        (MAPS.torque_per_thrust(tau), K_Q / K_T),
        (MAPS.speed(tau), 1.0 / np.sqrt(K_T)),
    ):
        np.testing.assert_allclose(found[away], exact[away], rtol=1e-4)  # interpolation over steps of 0.025
    lost = 1.0 - efficiency(B4_70, tau, MAPS.pitch_ratio(tau)) / efficiency(B4_70, tau, best)
    assert np.max(lost) < 1e-3  # the valley between two optima of equal height
    assert np.max(lost[away]) < 1e-7


def test_bollard_optimum_and_the_best_efficiency_beside_the_thesis() -> None:
    # [Ruth] 3.5.7: 0.58 from the polynomials of 1969; those of 1975 have it at 0.60.
    assert float(MAPS.pitch_ratio(0.0)) == pytest.approx(0.60, abs=0.005)
    # [Ruth] 3.7: K_Tc 0.2394, K_Qc 0.0226 at P/D 0.58; 1975: 0.2396, 0.0233.
    K_T, K_Q = B4_70.coefficients(0.0, 0.58)
    assert (float(K_T), float(K_Q)) == pytest.approx((0.2396, 0.0233), abs=5e-5)
    # [Ruth] (2.29): P/D 1.4 and tau 3.05; 1975: tau 3.5, where the efficiency is flat.
    tau = np.arange(1.0, 6.0, 0.01)
    best = optimal_pitch(B4_70, tau)
    peak = int(np.argmax(efficiency(B4_70, tau, best)))
    assert best[peak] == 1.4
    assert tau[peak] == pytest.approx(3.5, abs=0.05)
    # [Ruth] 2.2.1: P/D 1.36 at tau 2.1, and 3.4.2: 1.4 from tau 2.61 on, with K_Q 0.0439. In 1975's polynomials the
    # best pitch ratio jumps from 1.19 to the end of the range at tau 2.04, with K_Q from 0.0381 to 0.0545.
    at_end = tau[best == 1.4]
    assert at_end[0] == pytest.approx(2.04, abs=0.011)
    before = float(optimal_pitch(B4_70, 2.03))
    assert before == pytest.approx(1.19, abs=0.005)
    assert float(B4_70.coefficients(advance_number(B4_70, 2.03, before), before)[1]) == pytest.approx(0.0381, abs=1e-4)
    assert float(B4_70.coefficients(advance_number(B4_70, at_end[0], 1.4), 1.4)[1]) == pytest.approx(0.0545, abs=1e-4)


def test_constant_torque_coefficient_is_nearly_the_best() -> None:
    """[Ruth] 3.4.2: K_Qc = 0.033 has the least worst loss of efficiency, Table 3.3: 2.3 %."""
    tau = np.linspace(0.02, 4.0, 80)
    best = efficiency(B4_70, tau, optimal_pitch(B4_70, tau))

    def worst(torque_coefficient: float) -> float:
        pitch = pitch_of_torque_coefficient(B4_70, tau, torque_coefficient)
        return float(np.max(1.0 - efficiency(B4_70, tau, pitch) / best))

    losses = {k: worst(k) for k in np.arange(0.0300, 0.0391, 0.0005)}
    least = min(losses, key=lambda k: losses[k])
    # 1975: 0.0345, 1.3 %, and at 0.033 1.5 %.
    assert least == pytest.approx(0.0345, abs=0.0006)
    assert losses[least] == pytest.approx(0.0128, abs=5e-4)
    assert worst(0.033) == pytest.approx(0.0150, abs=5e-4)
    # Both ends of Figure 3.9 are worse than the middle.
    assert worst(0.0233) > 2.0 * losses[least]
    assert worst(0.0439) > 2.0 * losses[least]


def test_path_of_constant_torque_coefficient() -> None:
    tau = np.array([0.0, 1.0, 1.8])
    pitch = pitch_of_torque_coefficient(B4_70, tau, 0.033)
    K_Q = B4_70.coefficients(advance_number(B4_70, tau, pitch), pitch)[1]
    np.testing.assert_allclose(K_Q, 0.033, rtol=1e-7)  # both halvings stop at 1e-9 of a bracket of order 1
    assert (np.diff(pitch) > 0.0).all()  # a faster flow unloads the propeller
    # No pitch ratio loads it that much, or that little.
    assert float(pitch_of_torque_coefficient(B4_70, 0.0, 0.5)) == 1.4
    assert float(pitch_of_torque_coefficient(B4_70, 0.0, 0.001)) == 0.5


def test_pitch_of_thrust_coefficient_is_the_inverse_of_the_model() -> None:
    K_T, pitch = pitch_of_thrust_coefficient(B4_70, (0.5, 1.4))
    assert (np.diff(K_T) > 0.0).all()
    assert float(np.interp(0.2396, K_T, pitch)) == pytest.approx(0.58, abs=1e-4)  # K_T to four digits


def test_a_range_of_the_actuator_bounds_the_optimum() -> None:
    maps = optimal_maps(B4_70, (0.7, 1.1))
    assert float(maps.pitch_ratio(0.0)) == 0.7
    assert float(maps.pitch_ratio(5.0)) == 1.1


def test_maps_are_computed_once_for_propellers_alike() -> None:
    assert optimal_maps(WageningenBPropeller(1.0, 4, 0.7, 0.9)) is MAPS  # neither diameter nor design pitch matters
    assert optimal_maps(WageningenBPropeller(4.0, 5, 0.7, 0.58)) is not MAPS


def test_maps_hold_their_ends() -> None:
    assert MAPS.pitch_ratio(-1.0) == MAPS.pitch_ratio(0.0)
    assert MAPS.speed(1e6) == MAPS.speed(TAU_MAX)


@pytest.mark.parametrize("tau", [-0.1, math.nan, math.inf])
def test_bad_tau_is_refused(tau: float) -> None:
    with pytest.raises(InputError, match="tau: expected finite numbers not below 0"):
        optimal_pitch(B4_70, tau)
    with pytest.raises(InputError, match="tau: expected finite numbers not below 0"):
        advance_number(B4_70, tau, 0.8)


@pytest.mark.parametrize("pitch_range", [(0.4, 1.0), (0.6, 1.5), (1.0, 1.0), (1.2, 0.8)])
def test_bad_ranges_are_refused(pitch_range: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"pitch_range: expected a range within 0.5 to 1.4"):
        OptimalMaps(B4_70, pitch_range)


def feathering() -> TabulatedPropeller:
    """K_T = 0.4 P - J / 3 and K_Q = 0.004 + 0.05 P^2 - 0.002 J, from next to no pitch on."""
    pitch = np.linspace(0.01, 1.21, 13)
    J = np.linspace(0.0, 1.4, 15)
    K_T = 0.4 * pitch[:, np.newaxis] - J / 3.0
    K_Q = 0.004 + 0.05 * pitch[:, np.newaxis] ** 2 - 0.002 * J
    return TabulatedPropeller(0.1, 0.8, J.tolist(), K_T.tolist(), K_Q.tolist(), pitch.tolist())


def test_a_pitch_that_feathers_has_its_optimum_among_those_that_drive() -> None:
    model = feathering()
    # (0.004 + 0.05 P^2) / P^1.5 is least at P^2 = 3 * 0.004 / 0.05.
    assert float(optimal_pitch(model, 0.0)) == pytest.approx(math.sqrt(0.24), abs=1e-3)  # interpolation in the table
    low, high = thrust_pitches(model)
    assert low == pytest.approx(0.05 * 1.21, abs=0.014)  # a step of the search
    assert high == 1.21


def test_a_model_of_all_advance_numbers_has_the_same_roots() -> None:
    J = float(advance_number(Endless(4.0, 4, 0.7, 0.58), 1.3, 0.8))
    assert pytest.approx(float(advance_number(B4_70, 1.3, 0.8)), abs=1e-12) == J


class Endless(WageningenBPropeller):
    """Claims all advance numbers, as a four-quadrant model does; its cubics go on beyond K_T = 0."""

    def advance_number_end(self, pitch_ratio: ArrayLike) -> FloatArray:
        return np.full(np.shape(pitch_ratio), np.inf)


def test_a_propeller_of_one_pitch_has_no_optimum() -> None:
    with pytest.raises(InputError, match="pitch_range: expected a propeller model with a range of pitch ratios"):
        optimal_maps(BollardPropeller(0.1, 0.8, 0.4, 0.04))
