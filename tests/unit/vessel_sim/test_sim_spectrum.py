"""JONSWAP spectrum and the irregular sea made from it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from vessel_sim.waves import IrregularSea, Jonswap
from vessel_sim.waves.components import AMPLITUDE, OMEGA, WAVE_NUMBER

# [Ruth] 3.7.
SPECTRUM = Jonswap(significant_height=2.0, peak_period=5.9, peakedness=3.3)


def moment(spectrum: Jonswap, order: int, low: float, high: float) -> float:
    """Integral of omega^order S between multiples of the peak frequency."""
    peak = spectrum.peak_frequency
    edges = [low, *(x for x in (0.8, 1.0, 1.3, 2.0, 5.0) if low < x < high), high]
    parts = (
        quad(lambda w: w**order * float(spectrum.density(w)), a * peak, b * peak, epsabs=1e-13)[0]
        for a, b in pairwise(edges)
    )
    return sum(parts)


@given(height=st.floats(0.01, 20.0), period=st.floats(0.5, 20.0), gamma=st.floats(1.0, 7.0))
def test_significant_height_is_four_times_the_root_of_the_energy(height: float, period: float, gamma: float) -> None:
    # What lies beyond 50 times the peak is 0.2 / 0.2 * 50^-4 = 1.6e-7 of it at most.
    energy = moment(Jonswap(height, period, gamma), 0, 0.1, 50.0)
    assert 4.0 * math.sqrt(energy) == pytest.approx(height, rel=1e-6)


def test_without_peak_it_is_the_closed_form_of_bretschneider() -> None:
    # S = 5/16 H_s^2 omega_p^4 omega^-5 exp(-5/4 (omega_p / omega)^4).
    spectrum = Jonswap(2.0, 5.9, 1.0)
    peak = 2.0 * math.pi / 5.9
    omega = np.linspace(0.3, 4.0, 50)
    expected = 5.0 / 16.0 * 4.0 * peak**4 * omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4)
    np.testing.assert_allclose(spectrum.density(omega), expected, rtol=1e-9)


def test_density_at_the_peak_and_beside_it_by_hand() -> None:
    # omega_p = 1.06495; without its peak factor S_PM = 1.25 / 1.06495 exp(-1.25) = 0.336289 m^2 s. Times 3.3 and the
    # usual fit 1 - 0.287 ln 3.3 = 0.657343: 0.72949. The quadrature of the norm differs from that fit by 0.24 %.
    assert float(SPECTRUM.density(SPECTRUM.peak_frequency)) == pytest.approx(0.72949, rel=0.003)
    # At x = 1.09 the exponent of gamma is exp(-1/2) = 0.606531: x^-5 exp(-5/4 x^-4) = 0.649931 * 0.412495 = 0.268093
    # against exp(-1.25) = 0.286505 at the peak, times 3.3^(0.606531 - 1) = 0.625145: 0.584971 of it.
    ratio = SPECTRUM.density(1.09 * SPECTRUM.peak_frequency) / SPECTRUM.density(SPECTRUM.peak_frequency)
    assert float(ratio) == pytest.approx(0.584971, rel=1e-5)


def test_nothing_below_zero_frequency_nor_at_it() -> None:
    np.testing.assert_array_equal(SPECTRUM.density([-1.0, 0.0, 1e-9]), [0.0, 0.0, 0.0])


@pytest.mark.parametrize("seed", [0, 1, 2024])
@pytest.mark.parametrize("count", [1, 50, 200])
def test_every_realisation_has_the_significant_height(seed: int, count: int) -> None:
    amplitude = IrregularSea(SPECTRUM, 0.0, seed, count).components[:, AMPLITUDE]
    assert 4.0 * math.sqrt(0.5 * (amplitude**2).sum()) == pytest.approx(2.0, rel=1e-12)


def test_components_have_the_energy_of_the_spectrum_in_every_band() -> None:
    sea = IrregularSea(SPECTRUM, 0.0, seed=11)
    omega = sea.components[:, OMEGA] / SPECTRUM.peak_frequency
    whole = moment(SPECTRUM, 0, 0.1, 5.0)
    for low, high in ((0.1, 0.9), (0.9, 1.0), (1.0, 1.1), (1.1, 1.5), (1.5, 5.0)):
        share = np.mean((omega >= low) & (omega < high))
        # One component a share of 1/200: a band has at most one too many or too few at either edge.
        assert share == pytest.approx(moment(SPECTRUM, 0, low, high) / whole, abs=2.0 / 200.0)


def test_mean_frequencies_of_the_components() -> None:
    sea = IrregularSea(SPECTRUM, 0.0, seed=5)
    omega = sea.components[:, OMEGA]
    energy = moment(SPECTRUM, 0, 0.1, 5.0)
    # Within its share a component strays by its width; the last, from 3.1 to 5 times the peak, sets the bounds.
    assert omega.mean() == pytest.approx(moment(SPECTRUM, 1, 0.1, 5.0) / energy, rel=0.01)
    assert (omega**2).mean() == pytest.approx(moment(SPECTRUM, 2, 0.1, 5.0) / energy, rel=0.04)


def test_velocity_at_the_propeller_of_3_7() -> None:
    # Horizontal particle velocity at 5 m: variance integral omega^2 exp(-2 k z) S, against an hour of record.
    sea = IrregularSea(SPECTRUM, 0.0, seed=1)
    time = np.arange(0.0, 3600.0, 0.25)
    along = sea.particle_velocity(0.0, 0.0, 5.0, time)[:, 0]
    peak = SPECTRUM.peak_frequency
    expected = sum(
        quad(lambda w: w * w * math.exp(-10.0 * w * w / GRAVITY) * float(SPECTRUM.density(w)), a * peak, b * peak)[0]
        for a, b in ((0.1, 0.9), (0.9, 1.0), (1.0, 1.5), (1.5, 5.0))
    )
    # Standard deviation of the variance of an hour, from the width of the spectrum (bandwidth of some 0.25 rad/s, 140
    # independent groups): sqrt(2 / 280) = 8 %; three of them.
    assert along.var() == pytest.approx(expected, rel=0.25)
    components = sea.components
    realised = (
        0.5 * ((components[:, AMPLITUDE] * components[:, OMEGA] * np.exp(-components[:, WAVE_NUMBER] * 5.0)) ** 2).sum()
    )
    # The components themselves have no such scatter, only that of their places.
    assert realised == pytest.approx(expected, rel=0.02)


def test_elevation_of_an_hour() -> None:
    elevation = IrregularSea(SPECTRUM, 0.0, seed=2).elevation(0.0, 0.0, np.arange(0.0, 3600.0, 0.25))
    # As above: 4 % of the standard deviation, three of them.
    assert 4.0 * elevation.std() == pytest.approx(2.0, rel=0.12)
    assert elevation.mean() == pytest.approx(0.0, abs=0.01)
    # Rayleigh: of 700 waves the highest crest is some 1.8 m; half of it or twice it would be no Gaussian sea.
    assert 1.2 < elevation.max() < 2.6


def test_the_record_does_not_repeat_itself() -> None:
    # Correlation of the record with itself later, from the components. It decays within minutes and stays low for three
    # hours; equally spaced frequencies give 1 after 2 pi / distance, here 200 s.
    lag = np.arange(600.0, 10_800.0, 0.5)
    omega = IrregularSea(SPECTRUM, 0.0, seed=3).components[:, OMEGA]
    assert np.abs(np.cos(np.outer(lag, omega)).mean(axis=1)).max() < 0.4
    equal = 2.0 * math.pi / 200.0 * np.arange(10, 150)
    assert np.cos(np.outer(lag, equal)).mean(axis=1).max() > 0.999


def test_the_seed_fixes_the_sea() -> None:
    first, again, other = (IrregularSea(SPECTRUM, 0.3, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.components, again.components)
    assert (first.components[:, OMEGA] != other.components[:, OMEGA]).all()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((0.0, 5.9, 3.3), "significant_height: expected a number above 0, found 0.0"),
        ((2.0, -1.0, 3.3), "peak_period: expected a number above 0"),
        ((2.0, 5.9, 0.9), "peakedness: expected at least 1, found 0.9"),
        ((2.0, 5.9, math.nan), "peakedness: expected a finite number"),
    ],
)
def test_bad_spectra_are_refused(arguments: tuple[float, float, float], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        Jonswap(*arguments)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"direction": math.inf}, "direction: expected a finite number"),
        ({"count": 0}, "count: expected at least 1, found 0"),
        ({"cutoff": 1.0}, "cutoff: expected a number above 1, found 1.0"),
        ({"seed": -1}, "seed: expected at least 0, found -1"),
    ],
)
def test_bad_seas_are_refused(changes: dict, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        IrregularSea(**({"spectrum": SPECTRUM, "direction": 0.0, "seed": 0} | changes))
