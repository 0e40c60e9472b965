"""Water at a point: elevation and particle velocity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from support.box_hull import box_of
from vessel_sim import WaveSettings
from vessel_sim.waves import IrregularSea, Jonswap, Sea, Waves
from vessel_sim.waves.components import WIDTH

FORM = box_of(load_vessel("cybership3"))


def regular(amplitude: float = 0.1, period: float = 2.0, direction: float = 0.0, ramp: float = 0.0) -> Waves:
    return Waves(FORM, WaveSettings(amplitude=amplitude, period=period, direction=direction, ramp=ramp))


SEAS: list[Sea] = [regular(direction=0.7), IrregularSea(Jonswap(0.4, 3.0), -2.0, seed=3, count=30, spreading=8.0)]
points = st.floats(-20.0, 20.0)
depths = st.floats(0.1, 3.0)
times = st.floats(0.0, 100.0)


def test_particle_velocity_by_hand() -> None:
    # omega = pi, k = pi^2 / 9.81 = 1.00607; under the crest at 0.5 m: 0.1 pi exp(-0.50303) = 0.18997 m/s along.
    waves = regular(direction=math.pi / 2.0)
    assert waves.particle_velocity(0.0, 0.0, 0.5, 0.0) == pytest.approx([0.0, 0.18997, 0.0], abs=1e-5)
    # A quarter of a period later the surface falls through the mean level: down with the same speed.
    assert waves.particle_velocity(0.0, 0.0, 0.5, 0.5) == pytest.approx([0.0, 0.0, 0.18997], abs=1e-5)


def test_above_the_calm_surface_the_velocity_is_that_at_it() -> None:
    at_surface = SEAS[0].particle_velocity(1.0, 2.0, 0.0, 3.0)
    np.testing.assert_array_equal(SEAS[0].particle_velocity(1.0, 2.0, [-0.05, -3.0], 3.0), [at_surface, at_surface])


@pytest.mark.parametrize("sea", SEAS)
@given(north=points, east=points, time=times)
def test_the_surface_moves_with_the_water(sea: Sea, north: float, east: float, time: float) -> None:
    e = 1e-5
    rate = (sea.elevation(north, east, time + e) - sea.elevation(north, east, time - e)) / (2.0 * e)
    # Truncation e^2 omega^3 a / 6 is below 1e-8 up to omega = 10; rounding of phases of some 1e3, 1e-8.
    assert sea.particle_velocity(north, east, 0.0, time)[2] == pytest.approx(-rate, abs=1e-7)


@pytest.mark.parametrize("sea", SEAS)
@given(north=points, east=points, depth=depths, time=times)
def test_the_flow_has_no_sources_and_no_rotation(
    sea: Sea, north: float, east: float, depth: float, time: float
) -> None:
    e = 1e-4
    gradient = np.empty((3, 3))
    for i in range(3):
        step = e * np.eye(3)[i]
        after = sea.particle_velocity(north + step[0], east + step[1], depth + step[2], time)
        before = sea.particle_velocity(north - step[0], east - step[1], depth - step[2], time)
        gradient[i] = (after - before) / (2.0 * e)
    # Truncation e^2 k^3 a omega / 6 with k <= 12 1/m in the irregular sea: below 1e-6.
    assert np.trace(gradient) == pytest.approx(0.0, abs=2e-6)
    np.testing.assert_allclose(gradient, gradient.T, rtol=0.0, atol=2e-6)


def test_growing_waves_move_the_water_with_the_surface() -> None:
    waves = regular(direction=0.7, ramp=20.0)

    def at(t: float) -> tuple[float, np.ndarray]:
        return float(waves.elevation(1.0, 2.0, t)), waves.particle_velocity(1.0, 2.0, 0.0, t)

    rate = (at(6.0 + 1e-5)[0] - at(6.0 - 1e-5)[0]) / 2e-5
    assert at(6.0)[1][2] == pytest.approx(-rate, abs=1e-8)


def test_trains_add() -> None:
    waves = regular(amplitude=0.02, period=1.5)
    waves.apply(WaveSettings(amplitude=0.03, period=2.5, direction=1.0, ramp=4.0), 2.0)
    old = regular(amplitude=0.015, period=1.5)
    new = regular(amplitude=0.0075, period=2.5, direction=1.0)
    expected = old.elevation(1.0, 2.0, 3.0) + new.elevation(1.0, 2.0, 3.0)
    assert waves.elevation(1.0, 2.0, 3.0) == pytest.approx(expected, rel=1e-12)


def test_a_calm_sea_has_no_components() -> None:
    calm = regular(amplitude=0.0)
    assert calm.components.shape == (0, WIDTH)
    assert calm.elevation(1.0, 2.0, 3.0) == 0.0
    np.testing.assert_array_equal(calm.particle_velocity(1.0, 2.0, 3.0, 4.0), [0.0, 0.0, 0.0])


@pytest.mark.parametrize("sea", SEAS)
def test_points_and_times_are_broadcast(sea: Sea) -> None:
    north, time = np.linspace(-3.0, 3.0, 4)[:, None], np.linspace(0.0, 5.0, 5)
    elevation = sea.elevation(north, 1.0, time)
    velocity = sea.particle_velocity(north, 1.0, 0.3, time)
    assert elevation.shape == (4, 5)
    assert velocity.shape == (4, 5, 3)
    assert elevation[2, 3] == sea.elevation(north[2, 0], 1.0, time[3])
    np.testing.assert_array_equal(velocity[2, 3], sea.particle_velocity(north[2, 0], 1.0, 0.3, time[3]))


@pytest.mark.parametrize("sea", SEAS)
def test_dispersion_in_deep_water(sea: Sea) -> None:
    k, omega, cos_beta, sin_beta = sea.components[:, :4].T
    np.testing.assert_allclose(k * GRAVITY, omega**2, rtol=1e-14)
    np.testing.assert_allclose(cos_beta**2 + sin_beta**2, 1.0, rtol=1e-14)
