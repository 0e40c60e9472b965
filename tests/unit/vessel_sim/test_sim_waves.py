"""Waves: kinematics, hull averages against quadrature, encounter, drift, ramps, breaking."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from support.box_hull import box_of
from vessel_sim import SimulatorSettings, WaveSettings
from vessel_sim.waves import Waves
from vessel_sim.waves.components import OMEGA, WAVE_NUMBER

VESSEL = load_vessel("cybership3")
FORM = box_of(VESSEL)


def grown(settings: WaveSettings) -> Waves:
    return Waves(FORM, settings.model_copy(update={"ramp": 0.0}))


def test_wave_number_of_run_a() -> None:
    # [Ruth] 4.5.1: period 0.8 s, so lambda = g T^2 / (2 pi) = 0.999 m.
    assert 2.0 * math.pi / WaveSettings(period=0.8).wave_number == pytest.approx(0.999, abs=0.001)


def test_waves_travel_towards_their_direction() -> None:
    waves = grown(WaveSettings(amplitude=0.01, period=1.0, direction=math.pi / 2.0))
    length = 2.0 * math.pi / WaveSettings(period=1.0).wave_number
    assert waves.elevation(0.0, 0.0, 0.0) == pytest.approx(0.01)
    # A quarter of a period later the crest is a quarter of a wavelength east, and has not moved north.
    assert waves.elevation(7.0, length / 4.0, 0.25) == pytest.approx(0.01)
    assert waves.elevation(0.0, -length / 4.0, 0.25) == pytest.approx(-0.01)


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.0])
@pytest.mark.parametrize("period", [0.8, 1.3, 3.0])
def test_motion_is_the_mean_of_the_particle_displacements_over_the_hull(heading: float, period: float) -> None:
    settings = WaveSettings(amplitude=0.01, period=period, direction=2.2)
    north, east, time = 3.0, -1.0, 4.4
    k, omega = settings.wave_number, 2.0 * math.pi / period
    hull = VESSEL.hull

    def midpoints(count: int, width: float) -> np.ndarray:
        return ((np.arange(count) + 0.5) / count - 0.5) * width

    x, y = np.meshgrid(midpoints(400, hull.length), midpoints(200, hull.beam), indexing="ij")
    z = midpoints(200, hull.draught) - 0.5 * hull.draught
    c, s = math.cos(heading), math.sin(heading)
    along = (north + c * x - s * y) * math.cos(2.2) + (east + s * x + c * y) * math.sin(2.2)
    # Displacement of the particles along the direction of travel, linear theory.
    xi = -0.01 * np.exp(k * z).mean() * np.sin(k * along - omega * time)
    xi_north, xi_east = xi * math.cos(2.2), xi * math.sin(2.2)
    xi_x, xi_y = c * xi_north + s * xi_east, -s * xi_north + c * xi_east
    yaw = (x * xi_y - y * xi_x).sum() / (x**2 + y**2).sum()

    position, _ = grown(settings).motion((north, east, heading), (0.0, 0.0), time)
    # The midpoint rule errs by (k dx)^2 / 24, 2e-5 of the amplitude at the shortest wave.
    assert position == pytest.approx((xi_north.mean(), xi_east.mean(), yaw), abs=1e-6)


def test_a_long_wave_carries_the_hull_round_like_a_particle() -> None:
    # k T -> 0 and k L -> 0: horizontal motion with the amplitude of the wave, towards the crest's direction at it.
    waves = grown(WaveSettings(amplitude=0.1, period=30.0, direction=0.0))
    quarter, _ = waves.motion((0.0, 0.0, 0.0), (0.0, 0.0), 7.5)
    assert quarter == pytest.approx((0.1, 0.0, 0.0), abs=1e-4)  # k T / 2 = 4e-4 of it
    _, at_crest = waves.motion((0.0, 0.0, 0.0), (0.0, 0.0), 0.0)
    assert at_crest[0] == pytest.approx(0.1 * 2.0 * math.pi / 30.0, rel=1e-3)


@given(
    heading=st.floats(-3.0, 3.0),
    direction=st.floats(-3.0, 3.0),
    speed=st.floats(-0.5, 0.5),
    time=st.floats(0.5, 50.0),
    ramp=st.sampled_from([0.0, 100.0]),
)
def test_velocity_is_the_derivative_of_the_motion_of_a_moving_ship(
    heading: float, direction: float, speed: float, time: float, ramp: float
) -> None:
    settings = WaveSettings(amplitude=0.02, period=1.1, direction=direction, ramp=ramp)
    velocity = (speed, 0.3)
    waves = Waves(FORM, settings)

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        place = (velocity[0] * t, velocity[1] * t, heading)
        position, rate = waves.motion(place, velocity, t)
        return np.array(position), np.array(rate)

    e = 1e-5
    difference = (at(time + e)[0] - at(time - e)[0]) / (2.0 * e)
    # Central differences: truncation e^2 omega^3 a / 6 is below 1e-9, rounding of the phase (some 1e2) 1e-8.
    assert at(time)[1] == pytest.approx(difference, abs=1e-7)


def test_a_ship_under_way_meets_the_waves_at_the_frequency_of_encounter() -> None:
    settings = WaveSettings(amplitude=0.01, period=2.0, direction=math.pi)
    omega, speed = math.pi, 0.4
    # Head seas at 0.4 m/s: omega_e = omega + omega^2 U / g. After its period the ship moves as before.
    period = 2.0 * math.pi / (omega + omega**2 * speed / GRAVITY)
    waves = grown(settings)

    def motion(time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return waves.motion((speed * time, 0.0, 0.1), (speed, 0.0), time)

    for before, after in zip(motion(0.3), motion(0.3 + 3.0 * period), strict=True):
        assert after == pytest.approx(before, abs=1e-12)
    assert waves.components[0, [OMEGA, WAVE_NUMBER]] == pytest.approx([omega, omega**2 / GRAVITY], rel=1e-12)


def test_drift_in_head_seas_of_run_g() -> None:
    # 0.5 * 1000 * 9.81 * 0.04^2 * 0.44 / 2 = 1.727 N astern ([Ruth] Table 6.3 needs more than 1.7 N).
    waves = grown(WaveSettings(amplitude=0.04, period=0.8, direction=math.pi))
    x, y, n = waves.drift_force((0.0, 0.0, 0.0), 0.0)
    assert x == pytest.approx(-1.7266, abs=1e-4)
    assert (y, n) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_drift_on_the_beam() -> None:
    # 0.87 * 1000 * 9.81 * 0.02^2 * 1.97 / 2 = 3.3627 N to starboard, waves from port (towards east, heading north).
    waves = grown(WaveSettings(amplitude=0.02, period=0.8, direction=math.pi / 2.0))
    x, y, n = waves.drift_force((0.0, 0.0, 0.0), 0.0)
    assert y == pytest.approx(3.3627, abs=1e-4)
    assert (x, n) == pytest.approx((0.0, 0.0), abs=1e-12)
    # The same waves seen from a ship that heads east push it ahead.
    assert waves.drift_force((0.0, 0.0, 0.5 * math.pi), 0.0)[0] == pytest.approx(
        0.5 * 1000.0 * 9.81 * 0.02**2 * 0.44 / 2.0
    )


@given(direction=st.floats(-3.0, 3.0), factor=st.floats(0.1, 3.0))
def test_drift_grows_with_the_square_of_the_amplitude(direction: float, factor: float) -> None:
    def force(amplitude: float) -> np.ndarray:
        waves = grown(WaveSettings(amplitude=amplitude, period=1.5, direction=direction))
        return np.array(waves.drift_force((0.0, 0.0, math.acos(0.6)), 0.0))

    assert force(0.01 * factor) == pytest.approx(force(0.01) * factor**2, rel=1e-12)


def test_a_change_of_period_hands_over_without_a_jump() -> None:
    waves = grown(WaveSettings(amplitude=0.02, period=1.5, direction=0.0))
    before = waves.motion((1.0, 2.0, 0.3), (0.0, 0.0), 5.0)[0]
    waves.apply(WaveSettings(amplitude=0.03, period=2.5, direction=1.0, ramp=4.0), 5.0)
    assert waves.motion((1.0, 2.0, 0.3), (0.0, 0.0), 5.0)[0] == pytest.approx(before, abs=1e-15)
    after = waves.motion((1.0, 2.0, 0.3), (0.0, 0.0), 9.0)[0]
    expected = grown(WaveSettings(amplitude=0.03, period=2.5, direction=1.0))
    assert after == pytest.approx(expected.motion((1.0, 2.0, 0.3), (0.0, 0.0), 9.0)[0], rel=1e-9)


def test_breaking_waves_are_refused() -> None:
    # At 0.8 s the wavelength is 0.999 m: 0.0713 m is the highest amplitude.
    WaveSettings(amplitude=0.071, period=0.8)
    with pytest.raises(ValidationError, match=r"waves\.amplitude and waves\.period.*1/7.*found 0\.14[4-9]"):
        WaveSettings(amplitude=0.072, period=0.8)


@pytest.mark.parametrize("kind", ["jonswap", "ittc"])
def test_seas_steeper_than_any_are_refused(kind: str) -> None:
    # At a peak of 0.8 s the wavelength is 0.999 m: 0.0666 m is the largest significant height.
    WaveSettings.model_validate({"kind": kind, "significant_height": 0.0665, "peak_period": 0.8})
    with pytest.raises(ValidationError, match=r"waves\.significant_height and waves\.peak_period.*1/15.*found 0\.067"):
        WaveSettings.model_validate({"kind": kind, "significant_height": 0.067, "peak_period": 0.8})
    # Regular waves and seas have numbers of their own.
    WaveSettings.model_validate({"kind": kind, "amplitude": 1.0, "period": 0.8})
    WaveSettings(significant_height=1.0, peak_period=0.8)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("amplitude", -0.01),
        ("amplitude", math.nan),
        ("period", 0.0),
        ("ramp", -1.0),
        ("kind", "swell"),
        ("components", 0),
        ("spreading", -1.0),
        ("maker_distance", -1.0),
    ],
)
def test_bad_settings_are_refused_by_name(field: str, value: float) -> None:
    with pytest.raises(ValidationError, match=field):
        SimulatorSettings.model_validate({"waves": {field: value}})
