"""Waves that come and go: ramps, fronts that travel, steps put together; irregular seas of the simulator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from support.box_hull import box_of
from vessel_sim import Simulator, SimulatorInputs, SimulatorSettings, WaveSettings
from vessel_sim.noise import own_sequence
from vessel_sim.waves import IrregularSea, Jonswap, Waves
from vessel_sim.waves.components import AMPLITUDE, BETA, OMEGA, PHASE, START
from vessel_sim.waves.hull_motion import hull_motion

VESSEL = load_vessel("cybership3")
FORM = box_of(VESSEL)
H = VESSEL.simulation.time_step
STILL = SimulatorInputs(np.zeros(4), np.zeros(4))
OFF = {"amplitude": 0.0}


def amplitude(waves: Waves, time: float, north: float = 0.0) -> float:
    """Amplitude of waves that travel north, from the drift of a ship that heads north."""
    return math.sqrt(waves.drift_force((north, 0.0, 0.0), time)[0] / FORM.drift[0])


def test_amplitude_ramps_at_the_start_and_after_changes() -> None:
    settings = WaveSettings(amplitude=0.04, period=1.0, direction=0.0, ramp=2.0)
    waves = Waves(FORM, settings)
    assert [amplitude(waves, t) for t in (0.0, 1.0, 2.0, 3.0)] == pytest.approx([0.0, 0.02, 0.04, 0.04])
    # Without a maker they are everywhere at once.
    assert amplitude(waves, 1.0, 50.0) == pytest.approx(0.02)
    waves.apply(settings.model_copy(update={"amplitude": 0.01, "ramp": 3.0}), 3.0)
    assert [amplitude(waves, t) for t in (3.0, 4.0, 6.0, 9.0)] == pytest.approx([0.04, 0.03, 0.01, 0.01])
    waves.apply(settings.model_copy(update={"amplitude": 0.0, "ramp": 0.0}), 9.0)
    assert amplitude(waves, 9.0) == pytest.approx(0.0, abs=1e-9)  # the root of rounding
    assert float(waves.elevation(0.0, 0.0, 9.0)) == pytest.approx(0.0, abs=1e-17)


def test_a_change_within_a_ramp_starts_from_the_amplitude_there_is() -> None:
    settings = WaveSettings(amplitude=0.04, period=1.0, direction=0.0, ramp=4.0)
    waves = Waves(FORM, settings)
    waves.apply(settings.model_copy(update={"amplitude": 0.0, "ramp": 1.0}), 2.0)
    assert [amplitude(waves, t) for t in (1.0, 2.0, 2.5)] == pytest.approx([0.01, 0.02, 0.01])
    assert [amplitude(waves, t) for t in (3.0, 3.5, 10.0)] == pytest.approx([0.0] * 3, abs=1e-9)
    waves.apply(settings, 2.5)
    assert [amplitude(waves, t) for t in (2.5, 4.5, 6.5)] == pytest.approx([0.01, 0.025, 0.04])


def test_a_front_travels_with_the_group_velocity() -> None:
    # c_g = g T / (4 pi) = 0.78066 m/s at 1 s.
    settings = WaveSettings(amplitude=0.04, period=1.0, direction=0.0, ramp=2.0, maker_distance=5.0)
    waves = Waves(FORM, settings)
    speed = GRAVITY / (4.0 * math.pi)
    arrival = 5.0 / speed
    assert arrival == pytest.approx(6.405, abs=1e-3)
    assert amplitude(waves, arrival - 1e-3) == 0.0
    assert amplitude(waves, arrival + 1.0) == pytest.approx(0.02)
    assert amplitude(waves, arrival + 3.0) == pytest.approx(0.04)
    assert amplitude(waves, arrival + 1.0, north=-0.5 * speed) == pytest.approx(0.03)
    assert amplitude(waves, arrival + 1.0, north=1.1 * speed) == 0.0
    # Switched off at the maker, the waves under way still arrive, and end.
    waves.apply(settings.model_copy(update=OFF), 3.0)
    assert [amplitude(waves, t) for t in (arrival + 1.0, arrival + 2.5)] == pytest.approx([0.02, 0.04])
    assert amplitude(waves, arrival + 4.0) == pytest.approx(0.02)
    assert amplitude(waves, arrival + 5.0) == pytest.approx(0.0, abs=1e-9)
    # Off again before the ramp was over: what left the maker until then is under way.
    short = Waves(FORM, settings)
    short.apply(settings.model_copy(update=OFF | {"ramp": 0.5}), 1.0)
    assert [amplitude(short, arrival + t) for t in (0.5, 1.0, 1.25)] == pytest.approx([0.01, 0.02, 0.01])
    assert amplitude(short, arrival + 1.5) == pytest.approx(0.0, abs=1e-9)


def test_every_frequency_of_a_sea_arrives_at_its_own_time() -> None:
    settings = WaveSettings(
        kind="jonswap", significant_height=0.04, peak_period=1.2, direction=0.0, ramp=1.0, maker_distance=10.0
    )
    waves = Waves(FORM, settings, seed=1)
    arrival = 10.0 * 2.0 * waves.components[:, OMEGA] / GRAVITY
    np.testing.assert_allclose(waves.components[:, START], arrival, rtol=1e-12)
    assert float(waves.elevation(0.0, 0.0, 0.999 * arrival.min())) == 0.0
    assert float(np.abs(waves.elevation(0.0, 0.0, arrival.min() + np.linspace(0.5, 3.0, 20))).max()) > 0.0


@given(
    heading=st.floats(-3.0, 3.0),
    direction=st.floats(-3.0, 3.0),
    speed=st.floats(-0.5, 0.5),
    time=st.floats(1.0, 50.0),
)
def test_rates_are_derivatives_in_a_travelling_ramp(
    heading: float, direction: float, speed: float, time: float
) -> None:
    """The ship meets the front too: the amplitude at its place changes with 1 - U / c_g."""
    settings = WaveSettings(amplitude=0.02, period=1.1, direction=direction, ramp=100.0, maker_distance=0.5)
    waves, velocity = Waves(FORM, settings), (speed, 0.3)

    def at(t: float) -> tuple[np.ndarray, np.ndarray]:
        place = (velocity[0] * t, velocity[1] * t, heading)
        position, rate = hull_motion(waves.components, waves.response, place, velocity, t)
        return np.array(position), np.array(rate)

    e = 1e-5
    since = [
        t
        - (velocity[0] * math.cos(direction) + velocity[1] * math.sin(direction)) * t * 2.0 * 2.0 * math.pi / 1.1 / 9.81
        for t in (time - e, time + e)
    ]
    start = float(waves.components[0, START])
    if (since[0] - start) * (since[1] - start) <= 0.0:
        return  # the kink of the front itself
    difference = (at(time + e)[0] - at(time - e)[0]) / (2.0 * e)
    # Central differences, as in test_sim_first_order.
    assert at(time)[1] == pytest.approx(difference, abs=1e-7)


def test_steps_far_ahead_are_put_together() -> None:
    settings = WaveSettings(amplitude=0.04, period=1.0, direction=0.0, ramp=2.0, maker_distance=5.0)
    waves = Waves(FORM, settings)
    speed = GRAVITY / (4.0 * math.pi)
    waves.apply(settings.model_copy(update={"amplitude": 0.01}), 10.0)
    waves.apply(settings.model_copy(update=OFF), 20.0)
    assert len(waves.components) == 3
    # The last ramp is over at the origin at 22 s + 5 m / c_g; 20 lengths further 20 L / c_g later.
    passed = [start + 2.0 + (5.0 + 20.0 * FORM.length) / speed for start in (0.0, 10.0, 20.0)]
    before = amplitude(waves, passed[1] - 1.0), amplitude(waves, passed[1] + 0.5)
    waves.tidy(0.0, 0.0, passed[1] - 1e-6)
    assert len(waves.components) == 3
    waves.tidy(0.0, 0.0, passed[1] + 1e-6)
    assert waves.components[:, AMPLITUDE] == pytest.approx([0.01, -0.01], abs=1e-15)
    assert (amplitude(waves, passed[1] - 1.0), amplitude(waves, passed[1] + 0.5)) == pytest.approx(before, abs=1e-9)
    waves.tidy(0.0, 0.0, passed[2] + 1e-6)
    assert waves.components.shape[0] == 0
    assert waves.next_look == math.inf
    # On again, as if nothing had been.
    waves.apply(settings, 300.0)
    assert len(waves.components) == 1
    assert waves.components[0, [AMPLITUDE, PHASE]].tolist() == [0.04, 0.0]


def test_a_sea_comes_back_as_it_was() -> None:
    settings = WaveSettings(
        kind="ittc", significant_height=0.05, peak_period=1.5, components=20, spreading=6.0, ramp=1.0
    )
    waves = Waves(FORM, settings, seed=4)
    first = waves.components.copy()
    waves.apply(settings.model_copy(update={"significant_height": 0.0}), 10.0)
    waves.tidy(0.0, 0.0, 20.0)
    assert len(waves.components) == 0
    waves.apply(settings.model_copy(update={"significant_height": 0.1}), 30.0)
    columns = [OMEGA, BETA, PHASE]
    np.testing.assert_array_equal(waves.components[:, columns], first[:, columns])
    np.testing.assert_allclose(waves.components[:, AMPLITUDE], 2.0 * first[:, AMPLITUDE], rtol=1e-12)
    # A higher sea of the same shape adds to the waves there are; another shape replaces them.
    waves.apply(settings.model_copy(update={"significant_height": 0.08}), 40.0)
    assert len(waves.components) == 40
    waves.apply(settings.model_copy(update={"kind": "jonswap", "significant_height": 0.08}), 50.0)
    for time in (70.0, 71.0):
        waves.tidy(0.0, 0.0, time)
    expected = Waves(FORM, settings.model_copy(update={"kind": "jonswap", "significant_height": 0.08}), seed=4)
    np.testing.assert_allclose(waves.components[:, : PHASE + 1], expected.components[:, : PHASE + 1], rtol=1e-12)


def test_the_same_again_changes_nothing() -> None:
    settings = WaveSettings(kind="jonswap", significant_height=0.05, peak_period=1.5, components=7)
    waves = Waves(FORM, settings, seed=4)
    before = waves.components
    waves.apply(settings.model_copy(update={"ramp": 7.0}), 3.0)
    assert waves.components is before


def test_a_change_of_mind_at_one_instant_leaves_no_trace() -> None:
    waves = Waves(FORM, WaveSettings())
    settings = WaveSettings(amplitude=0.04, period=1.0, ramp=2.0)
    waves.apply(settings, 5.0)
    waves.apply(settings.model_copy(update={"period": 2.0}), 5.0)
    assert waves.components[:, OMEGA] == pytest.approx([math.pi])
    waves.apply(settings, 5.0)
    assert waves.components[:, OMEGA] == pytest.approx([2.0 * math.pi])
    assert waves.components[:, AMPLITUDE].tolist() == [0.04]


# The simulator -------------------------------------------------------------------------------------------------------


SEA = WaveSettings(kind="jonswap", significant_height=0.05, peak_period=1.5, components=30, spreading=10.0, ramp=0.0)


def test_the_sea_has_a_stream_of_its_own() -> None:
    """Noise of a run does not change with the sea, and the sea is that of the documented stream."""
    calm, rough = (Simulator(VESSEL, SimulatorSettings(seed=5, waves=w)) for w in (WaveSettings(), SEA))
    assert calm.step(STILL, H).shaft_speed == pytest.approx(rough.step(STILL, H).shaft_speed, abs=1e-3)
    expected = IrregularSea(Jonswap(0.05, 1.5), math.pi, own_sequence(5, "sea"), 30, spreading=10.0)
    np.testing.assert_array_equal(rough._waves.components[:, : PHASE + 1], expected.components[:, : PHASE + 1])
    other = Simulator(VESSEL, SimulatorSettings(seed=6, waves=SEA))
    assert (rough._waves.components[:, PHASE] != other._waves.components[:, PHASE]).all()


def test_truth_has_the_elevation_and_the_drift_of_the_place() -> None:
    sim = Simulator(VESSEL, SimulatorSettings(waves=SEA))
    for _ in range(50):
        sim.step(STILL, H)
        truth = sim.truth()
        north, east, _ = truth.position
        assert truth.wave_elevation == pytest.approx(sim.elevation(north, east), rel=1e-12)
        place = tuple(truth.position.tolist())
        assert truth.wave_force == pytest.approx(sim._waves.drift_force(place, sim.time), rel=1e-12)
    assert np.abs(truth.wave_force).max() > 0.0


def test_waves_that_have_gone_leave_the_simulator_calm() -> None:
    settings = SimulatorSettings(waves=SEA.model_copy(update={"ramp": 0.5}))
    sim = Simulator(VESSEL, settings)
    sim.step(STILL, H)
    sim.apply(settings.model_copy(update={"waves": settings.waves.model_copy(update={"significant_height": 0.0})}))
    for _ in range(100):
        sim.step(STILL, H)
    assert sim._waves.components.shape[0] == 0
    assert sim.truth().wave_elevation == 0.0
    assert sim.truth().wave_force.tolist() == [0.0] * 3


def test_the_wave_maker_stays_where_it_is() -> None:
    sim = Simulator(VESSEL)
    asked = SimulatorSettings(waves=WaveSettings(amplitude=0.01, maker_distance=3.0))
    with pytest.raises(
        InputError, match=r"waves\.maker_distance: cannot change during a run, expected 0\.0, found 3\.0"
    ):
        sim.apply(asked)
    assert sim._waves.components.shape[0] == 0
