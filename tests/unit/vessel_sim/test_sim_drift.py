"""Slowly varying drift: one component, two, many; signs; mean over a long record."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from marine_model.wave_response import WaveResponse
from support.box_hull import box_of
from vessel_sim.waves import ComputedHull, IrregularSea, Jonswap
from vessel_sim.waves.components import AMPLITUDE, OMEGA, component_table
from vessel_sim.waves.drift import drift_force

Array = NDArray[np.float64]
VESSEL = load_vessel("cybership3")
FORM = box_of(VESSEL)
REST = (0.0, 0.0, 0.0)


def drift_of(frequency: Array) -> Array:
    """Surge and yaw drift that differ with the frequency, and surge in its sign; over rho g L and rho g L^2."""
    return np.stack([0.2 * np.cos(frequency), 0.1 * frequency, 0.01 * frequency**2], axis=-1)


# Dense: between frequencies the response is linear.
FREQUENCY = np.linspace(0.05, 12.0, 4801)
HULL = ComputedHull(
    WaveResponse(
        FREQUENCY,
        np.linspace(0.0, math.pi, 19),
        np.zeros((FREQUENCY.size, 19, 6), dtype=np.complex128),
        np.repeat(drift_of(FREQUENCY)[:, None, :], 19, axis=1),
    ),
    FORM.length,
    VESSEL.density,
)
SCALE = VESSEL.density * GRAVITY * FORM.length * np.array([1.0, 1.0, FORM.length])


def per_square(omega: Array) -> Array:
    """D of ``HULL`` for waves from port, N/m^2, N/m^2, N/m."""
    drift = HULL.response.at(omega * math.sqrt(FORM.length / GRAVITY))[1][:, 0]
    return np.asarray(drift * SCALE)


@given(
    amplitude=st.floats(0.001, 0.1),
    period=st.floats(0.5, 5.0),
    heading=st.floats(-3.0, 3.0),
    time=st.floats(0.0, 100.0),
    phase=st.floats(0.0, 6.0),
)
def test_one_component_gives_its_mean_drift_at_all_times(
    amplitude: float, period: float, heading: float, time: float, phase: float
) -> None:
    omega = np.array([2.0 * math.pi / period])
    components = component_table(omega, heading + 1.0, amplitude, phase)
    force = np.array(drift_force(components, HULL.table(components), (2.0, -1.0, heading), time))
    assert force == pytest.approx(amplitude**2 * per_square(omega)[0], rel=1e-12, abs=1e-15)


def test_waves_from_the_other_side_push_the_other_way() -> None:
    omega = np.array([4.0])
    port, starboard = (component_table(omega, b, 0.05, 0.0) for b in (0.9, -0.9))
    x, y, n = drift_force(port, HULL.table(port), REST, 0.0)
    assert drift_force(starboard, HULL.table(starboard), REST, 0.0) == pytest.approx((x, -y, -n), rel=1e-12)


def test_two_components_beat_with_the_difference_of_their_frequencies() -> None:
    omega, amplitude = np.array([3.0, 3.5]), np.array([0.03, 0.05])
    components = component_table(omega, 0.7, amplitude, [0.4, 1.0])
    response = HULL.table(components)
    d = per_square(omega)
    assert (d[:, 0] < 0.0).tolist() == [True, True] or (d[:, 0] > 0.0).tolist() == [True, True]
    mean = (amplitude[:, None] ** 2 * d).sum(axis=0)
    beat = 2.0 * amplitude[0] * amplitude[1] * np.sqrt(d[0] * d[1]) * np.sign(d[0])
    for time in np.linspace(0.0, 30.0, 41):
        theta = -omega * time + [0.4, 1.0]
        expected = mean + beat * math.cos(theta[0] - theta[1])
        assert drift_force(components, response, REST, float(time)) == pytest.approx(expected, rel=1e-10)


def test_components_that_push_opposite_ways_do_not_beat() -> None:
    # cos(omega sqrt(L / g)) changes its sign at 3.5 rad/s.
    omega, amplitude = np.array([2.5, 4.5]), np.array([0.03, 0.05])
    components = component_table(omega, 0.7, amplitude, 0.0)
    response = HULL.table(components)
    d = per_square(omega)[:, 0]
    assert d[0] > 0.0 > d[1]
    forces = [drift_force(components, response, REST, float(time))[0] for time in np.linspace(0.0, 30.0, 41)]
    assert forces == pytest.approx([float(amplitude**2 @ d)] * 41, rel=1e-10)


def test_the_drift_of_a_ship_under_way_beats_with_the_encounter() -> None:
    omega = np.array([3.0, 3.5])
    components = component_table(omega, 0.0, 0.03, 0.0)
    response = HULL.table(components)
    # Going with the waves at 0.4 m/s: theta' = k U - omega.
    rate = omega**2 / GRAVITY * 0.4 - omega
    period = 2.0 * math.pi / abs(rate[0] - rate[1])
    one, again = (drift_force(components, response, (0.4 * t, 0.0, 0.0), t) for t in (1.0, 1.0 + period))
    assert again == pytest.approx(one, rel=1e-9)


@pytest.mark.parametrize("spreading", [0.0, 10.0])
def test_the_mean_of_a_long_record_is_the_integral_over_the_spectrum(spreading: float) -> None:
    """F mean = 2 integral of S D: the energy of a component is a^2 / 2."""
    spectrum = Jonswap(0.1, 1.6)
    peak = spectrum.peak_frequency
    expected = np.array(
        [
            sum(
                quad(
                    lambda w, j=axis: 2.0 * float(spectrum.density(w)) * per_square(np.array([w]))[0, j],
                    a * peak,
                    b * peak,
                )[0]
                for a, b in ((0.1, 0.9), (0.9, 1.0), (1.0, 1.3), (1.3, 2.0), (2.0, 5.0))
            )
            for axis in range(3)
        ]
    )
    sea = IrregularSea(spectrum, 0.8, seed=3, count=100, spreading=spreading)
    components = sea.components
    realised = (components[:, AMPLITUDE, None] ** 2 * per_square(components[:, OMEGA])).sum(axis=0)
    if spreading == 0.0:
        # Places within equal shares of the energy: off by the spread of the last share, from 2.6 to 5 times the peak.
        assert realised[:2] == pytest.approx(expected[:2], rel=0.02, abs=0.02 * abs(expected[1]))
    response = HULL.table(components)
    forces = np.array([drift_force(components, response, REST, 0.5 * k) for k in range(7200)])
    if spreading == 0.0:
        # An hour of beats: the force has the deviation of an exponential distribution, as large as its mean where all
        # D have one sign, and some 600 independent groups (bandwidth 1 rad/s): 1/sqrt(600) = 4 %; three of them.
        scale = (components[:, AMPLITUDE, None] ** 2 * np.abs(per_square(components[:, OMEGA]))).sum(axis=0)
        assert np.abs(forces.mean(axis=0) - realised).max() <= (0.12 * scale).max()
        assert forces[:, 1].std() == pytest.approx(scale[1], rel=0.2)
    # The energy in beats is there whatever the directions.
    assert forces[:, 1].std() > 0.5 * abs(forces[:, 1].mean())


def test_no_sums_of_frequencies() -> None:
    """Slow only: what lies above the band of differences has no energy."""
    sea = IrregularSea(Jonswap(0.1, 1.6), 0.8, seed=4, count=50, cutoff=2.0)
    components = sea.components
    response = HULL.table(components)
    step = 0.05
    forces = np.array([drift_force(components, response, REST, step * k)[1] for k in range(8192)])
    window = np.hanning(forces.size)
    energy = np.abs(np.fft.rfft((forces - forces.mean()) * window)) ** 2
    frequency = 2.0 * math.pi * np.fft.rfftfreq(forces.size, step)
    band = components[:, OMEGA].max() - components[:, OMEGA].min()
    # The Hann window leaks by 1e-7 and less a few lines away.
    assert energy[frequency > 1.02 * band].sum() < 1e-6 * energy.sum()
