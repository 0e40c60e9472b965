"""Short-crested seas: the spreading function, and seas made with it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from marine_model.errors import InputError
from vessel_sim.waves import IrregularSea, Jonswap, spread_directions
from vessel_sim.waves.components import AMPLITUDE, BETA, COS_BETA, OMEGA, PHASE, SIN_BETA

SPECTRUM = Jonswap(0.1, 1.6)


@given(exponent=st.floats(0.2, 100.0), share=st.floats(0.001, 0.999))
def test_the_share_of_energy_below_a_direction(exponent: float, share: float) -> None:
    def density(delta: float) -> float:
        return math.cos(0.5 * delta) ** (2.0 * exponent)

    found = float(spread_directions(share, exponent))
    # In halves, so that the quadrature finds a narrow peak at 0.
    whole = 2.0 * quad(density, 0.0, math.pi, epsabs=1e-13, points=[min(3.0, 5.0 / math.sqrt(exponent))])[0]
    above = quad(density, 0.0, abs(found), epsabs=1e-13)[0]
    assert 0.5 + math.copysign(above, found) / whole == pytest.approx(share, abs=1e-9)


def test_with_one_the_share_has_a_closed_form() -> None:
    # cos^2(delta / 2) = (1 + cos delta) / 2: F = (delta + sin delta) / (2 pi) + 1/2.
    delta = spread_directions(np.linspace(0.0, 1.0, 11), 1.0)
    np.testing.assert_allclose((delta + np.sin(delta)) / (2.0 * math.pi) + 0.5, np.linspace(0.0, 1.0, 11), atol=1e-12)
    assert delta[[0, 5, 10]] == pytest.approx([-math.pi, 0.0, math.pi], abs=1e-7)  # flat there: the root of rounding


@pytest.mark.parametrize("exponent", [2.0, 10.0, 50.0])
def test_mean_direction_and_spread_of_a_sea(exponent: float) -> None:
    sea = IrregularSea(SPECTRUM, 0.8, seed=2, count=400, spreading=exponent)
    assert 4.0 * math.sqrt(0.5 * (sea.components[:, AMPLITUDE] ** 2).sum()) == pytest.approx(0.1, rel=1e-12)
    away = sea.components[:, BETA] - 0.8
    # First harmonic of cos^2s(delta / 2): s / (s + 1) along the main direction. One component in every 1/400.
    assert np.cos(away).mean() == pytest.approx(exponent / (exponent + 1.0), abs=0.003)
    assert np.sin(away).mean() == pytest.approx(0.0, abs=0.005)
    np.testing.assert_allclose(sea.components[:, COS_BETA], np.cos(0.8 + away), atol=1e-15)
    np.testing.assert_allclose(sea.components[:, SIN_BETA], np.sin(0.8 + away), atol=1e-15)
    # Frequency and direction have nothing to do with each other: 1/sqrt(400) = 0.05, three of them.
    assert abs(np.corrcoef(sea.components[:, OMEGA], away)[0, 1]) < 0.15


def test_long_crested_seas_are_what_they_were_before_there_was_spreading() -> None:
    place, angle = np.random.Generator(np.random.PCG64(9)).random((2, 50))
    components = IrregularSea(SPECTRUM, 0.3, seed=9, count=50).components
    np.testing.assert_array_equal(components[:, BETA], 0.3)
    np.testing.assert_array_equal(components[:, PHASE], 2.0 * math.pi * angle)
    np.testing.assert_array_equal(components[:, OMEGA], SPECTRUM.frequencies((np.arange(50) + place) / 50, 5.0))
    spread = IrregularSea(SPECTRUM, 0.3, seed=9, count=50, spreading=4.0).components
    np.testing.assert_array_equal(spread[:, [OMEGA, PHASE]], components[:, [OMEGA, PHASE]])


@pytest.mark.parametrize("exponent", [0.0, -1.0, math.nan])
def test_bad_exponents_are_refused(exponent: float) -> None:
    with pytest.raises(InputError, match="exponent: expected a"):
        spread_directions(0.5, exponent)
    if exponent != 0.0:
        with pytest.raises(InputError, match=r"(exponent|spreading): expected a"):
            IrregularSea(SPECTRUM, 0.0, 1, spreading=exponent)
