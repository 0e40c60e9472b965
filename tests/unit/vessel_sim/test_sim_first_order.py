"""First-order motion of the hull in six degrees of freedom: quadrature, limits, rates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from support.box_hull import box_of
from vessel_sim import WaveSettings
from vessel_sim.waves import IrregularSea, Jonswap, Waves
from vessel_sim.waves.hull_form import box_response
from vessel_sim.waves.hull_motion import hull_motion

VESSEL = load_vessel("cybership3")
FORM = box_of(VESSEL)
LENGTH, BEAM, DRAUGHT = FORM.box


def sea(amplitude: float, period: float, direction: float) -> Waves:
    return Waves(FORM, WaveSettings(amplitude=amplitude, period=period, direction=direction, ramp=0.0))


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0])
@pytest.mark.parametrize("period", [0.8, 1.3, 3.0])
def test_heave_roll_and_pitch_fit_the_vertical_displacement_of_the_water(heading: float, period: float) -> None:
    north, east, time, amplitude = 3.0, -1.0, 4.4, 0.01
    waves = sea(amplitude, period, 2.2)
    k = WaveSettings(period=period).wave_number

    def midpoints(count: int, width: float) -> np.ndarray:
        return ((np.arange(count) + 0.5) / count - 0.5) * width

    x, y = np.meshgrid(midpoints(400, LENGTH), midpoints(200, BEAM), indexing="ij")
    z = midpoints(200, DRAUGHT) + 0.5 * DRAUGHT
    c, s = math.cos(heading), math.sin(heading)
    up = waves.elevation(north + c * x - s * y, east + s * x + c * y, time) * np.exp(-k * z).mean()
    # Plane that fits best: up = -heave + pitch x - roll y, as the bow rises with pitch, the port side with roll.
    heave, pitch, roll = -up.mean(), (x * up).sum() / (x**2).sum(), -(y * up).sum() / (y**2).sum()

    moved, _ = hull_motion(waves.components, waves.response, (north, east, heading), (0.0, 0.0), time)
    # The midpoint rule errs by (k dx)^2 / 24, 2e-5 of the amplitude, or slope k a <= 0.063, at the shortest wave.
    assert moved[2:5] == pytest.approx((heave, roll, pitch), abs=2e-6)


@given(direction=st.floats(-3.1, 3.1), heading=st.floats(-3.1, 3.1), time=st.floats(0.0, 60.0))
def test_in_a_long_wave_the_hull_floats_on_the_surface(direction: float, heading: float, time: float) -> None:
    period, amplitude = 60.0, 1.0  # k L = 2e-3
    waves = sea(amplitude, period, direction)
    k = WaveSettings(period=period).wave_number
    moved, _ = hull_motion(waves.components, waves.response, (2.0, 5.0, heading), (0.0, 0.0), time)
    c, s, e = math.cos(heading), math.sin(heading), 1e-3
    north, east = np.array([2.0 + e * c, 2.0 - e * c]), np.array([5.0 + e * s, 5.0 - e * s])
    ahead = -np.diff(waves.elevation(north, east, time))[0] / (2.0 * e)
    north, east = np.array([2.0 - e * s, 2.0 + e * s]), np.array([5.0 + e * c, 5.0 - e * c])
    right = -np.diff(waves.elevation(north, east, time))[0] / (2.0 * e)
    # Bow up where the surface rises ahead, starboard up (negative roll) where it rises to starboard.
    assert moved[4] == pytest.approx(ahead, abs=2e-4 * k)
    assert moved[3] == pytest.approx(-right, abs=2e-4 * k)


@given(direction=st.floats(-3.1, 3.1))
def test_in_short_waves_the_hull_lies_still(direction: float) -> None:
    # e < 1 / (k T) alone; with it 6 / L, 6 / B for the angles, of which j1 <= 0.44.
    k = 2.0e4
    response = box_response(FORM.box, k, math.cos(direction), math.sin(direction))
    assert np.abs(response[:3]).max() <= 1.0 / (k * DRAUGHT)
    # In metres of the wave's own slope k a.
    assert np.abs(response[3:]).max() / k <= 6.0 * 0.44 / (BEAM * DRAUGHT * k * k) * (1.0 + LENGTH / BEAM)


@given(
    heading=st.floats(-3.0, 3.0),
    direction=st.floats(-3.0, 3.0),
    speed=st.floats(-0.5, 0.5),
    time=st.floats(0.5, 50.0),
    ramp=st.sampled_from([0.0, 100.0]),
)
def test_rates_are_the_derivatives_of_the_motion_of_a_moving_ship(
    heading: float, direction: float, speed: float, time: float, ramp: float
) -> None:
    settings = WaveSettings(amplitude=0.02, period=1.1, direction=direction, ramp=ramp)
    velocity = (speed, 0.3)
    waves = Waves(FORM, settings)

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        position, rate = hull_motion(
            waves.components, waves.response, (velocity[0] * t, velocity[1] * t, heading), velocity, t
        )
        return np.array(position), np.array(rate)

    e = 1e-5
    difference = (at(time + e)[0] - at(time - e)[0]) / (2.0 * e)
    # Central differences: truncation e^2 omega^3 |motion| / 6 is below 1e-9, rounding of the phase (some 1e2) 1e-8.
    assert at(time)[1] == pytest.approx(difference, abs=1e-7)


def test_head_seas_neither_roll_nor_sway_nor_yaw() -> None:
    waves = sea(0.02, 1.5, math.pi)
    moved, rate = hull_motion(waves.components, waves.response, (0.3, 0.0, 0.0), (0.1, 0.0), 0.7)
    for motion in (moved, rate):
        assert (motion[1], motion[3], motion[5]) == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
        assert abs(motion[2]) > 1e-4
        assert abs(motion[4]) > 1e-4


def test_an_irregular_sea_moves_the_hull_by_the_sum_of_its_components() -> None:
    components = IrregularSea(Jonswap(0.05, 1.6), 0.4, seed=7, count=20, spreading=5.0).components
    response = FORM.table(components)
    place = (1.0, -2.0, 0.9)
    whole = np.array(hull_motion(components, response, place, (0.1, 0.0), 12.0))
    parts = sum(
        np.array(hull_motion(components[i : i + 1], response[i : i + 1], place, (0.1, 0.0), 12.0)) for i in range(20)
    )
    np.testing.assert_allclose(whole, parts, rtol=0.0, atol=1e-15)
