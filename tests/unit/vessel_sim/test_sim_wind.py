"""Wind over the simulated vessel: profile, spectrum, gusts, scale, force on the hull, anemometer."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.wind import wind_force
from vessel_sim import Simulator, SimulatorInputs, SimulatorSettings, WindSettings
from vessel_sim.wind import Wind, npd
from vessel_sim.wind.gusts import AMPLITUDE, FREQUENCY, components
from vessel_sim.wind.load import speed_now

VESSEL = load_vessel("cybership3")
H = VESSEL.simulation.time_step
STILL = SimulatorInputs(np.zeros(4), np.zeros(4))
ROOT = math.sqrt(VESSEL.scale)


def simulator(seed: int = 1, vessel: Vessel = VESSEL, **wind: Any) -> Simulator:
    return Simulator(vessel, SimulatorSettings(seed=seed, sensor_noise=False, wind=WindSettings(**wind)))


def sail(sim: Simulator, seconds: float) -> None:
    for _ in range(round(seconds / H)):
        sim.step(STILL, H)


# Profile and spectrum ------------------------------------------------------------------------------------------------


def test_profile_by_hand() -> None:
    assert npd.speed_at(10.0, 15.0) == 15.0
    # C = 0.0573 sqrt(1 + 0.15 * 20) = 0.1146; at 50 m: 20 * (1 + 0.1146 ln 5) = 23.689.
    assert npd.speed_at(50.0, 20.0) == pytest.approx(23.689, abs=5e-4)


def test_spectrum_by_hand() -> None:
    # At U = 10 m/s, z = 10 m and f~ = 1: 320 / 2^(5 / (3 * 0.468)).
    assert npd.spectrum(np.array(1.0 / 172.0), 10.0, 10.0) == pytest.approx(320.0 / 2.0**3.5612535613)
    assert npd.spectrum(np.array(0.0), 10.0, 10.0) == pytest.approx(320.0)


@pytest.mark.parametrize(("mean", "height"), [(2.0, 3.0), (15.0, 5.5), (30.0, 60.0)])
def test_closed_form_of_the_variance_is_the_integral(mean: float, height: float) -> None:
    def integrand(log_frequency: float) -> float:
        frequency = math.exp(log_frequency)
        return frequency * float(npd.spectrum(np.array(frequency), mean, height))

    expected = quad(integrand, math.log(npd.LOWEST), math.log(npd.HIGHEST), epsrel=1e-10)[0]
    found = np.diff(npd.variance_below(np.array([npd.LOWEST, npd.HIGHEST]), mean, height))[0]
    assert found == pytest.approx(expected, rel=1e-9)


# Gusts ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 7, 200])
def test_components_carry_the_whole_variance(count: int) -> None:
    table = components(count, 2.74, 0.183, VESSEL.scale, seed=4)
    total = npd.variance_below(np.array([npd.LOWEST, npd.HIGHEST]), 2.74 * ROOT, 0.183 * VESSEL.scale)
    assert (table[:, AMPLITUDE] ** 2).sum() / 2.0 == pytest.approx(np.diff(total)[0] / VESSEL.scale, rel=1e-12)
    assert (np.diff(table[:, FREQUENCY]) > 0.0).all()


def test_gusts_are_those_of_the_ship_in_the_time_of_the_model() -> None:
    model = components(50, 15.0 / ROOT, 5.0 / VESSEL.scale, VESSEL.scale, seed=2)
    ship = components(50, 15.0, 5.0, 1.0, seed=2)
    for time in (0.0, 100.0, 1234.5):
        assert ROOT * speed_now(0.0, model, time / ROOT) == pytest.approx(speed_now(0.0, ship, time), abs=1e-9)


def test_realised_gusts_have_the_spectrum() -> None:
    table = components(400, 15.0, 10.0, 1.0, seed=11)
    time = np.arange(0.0, 40_000.0, 0.5)
    speed = np.array([speed_now(0.0, table, t) for t in time])
    frequency, found = welch(speed, fs=2.0, nperseg=8192)
    for low, high in ((0.005, 0.02), (0.02, 0.1), (0.1, 0.4)):
        band = (frequency >= low) & (frequency < high)
        # Bands of 47 components or more: their number in a band is right to one, the ends of a band to a bin.
        assert found[band].mean() == pytest.approx(npd.spectrum(frequency[band], 15.0, 10.0).mean(), rel=0.1)


def test_gusts_differ_by_seed_and_repeat_by_seed() -> None:
    one, other, again = (components(20, 2.0, 0.2, 30.0, seed) for seed in (1, 2, 1))
    np.testing.assert_array_equal(one, again)
    assert not np.isclose(one[:, FREQUENCY], other[:, FREQUENCY]).any()


# Force on the hull ---------------------------------------------------------------------------------------------------


def test_speed_at_the_centroid_comes_from_the_profile_of_the_ship() -> None:
    forces = VESSEL.wind_forces
    assert forces is not None
    wind = Wind(VESSEL, WindSettings(speed=15.0 / ROOT, direction=0.5), 0)
    speed = npd.speed_at(forces.centroid_height * VESSEL.scale, 15.0) / ROOT
    assert wind.velocity(7.0) == pytest.approx((speed * math.cos(0.5), speed * math.sin(0.5)))


def test_wind_pushes_where_it_blows_and_less_on_a_hull_that_runs_before_it() -> None:
    wind = Wind(VESSEL, WindSettings(speed=2.7, direction=0.0), 0)
    at_rest = wind.force(0.0, 0.0, 0.0, 0.0)
    assert at_rest[0] > 0.0
    assert at_rest[1:] == pytest.approx((0.0, 0.0), abs=1e-15)
    assert 0.0 < wind.force(0.0, 0.0, 0.5, 0.0)[0] < at_rest[0]
    # Heading east, the same wind comes from starboard: it pushes to port.
    assert wind.force(0.0, math.pi / 2, 0.0, 0.0)[1] < 0.0


def test_a_ship_adrift_ends_up_where_wind_and_water_balance() -> None:
    sim = simulator(speed=2.74, direction=0.0)  # following wind, which leaves the heading alone
    sail(sim, 300.0)
    truth = sim.truth()
    u = float(truth.velocity[0])
    data = VESSEL.on_surface()[0]
    resistance = (data.linear_damping[0][0] + data.quadratic_damping[0] * u) * u
    # After 300 s, ten time constants of surge and more.
    assert truth.wind_force[0] == pytest.approx(resistance, rel=1e-6)
    assert truth.velocity[1:] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_wind_off_leaves_a_run_as_it_was_to_the_bit() -> None:
    without = load_vessel("cybership3").model_copy(update={"wind_forces": None})
    inputs = SimulatorInputs(np.array([0.0, 0.01, 0.05, 0.05]), np.zeros(4))
    one, other = Simulator(VESSEL, SimulatorSettings(seed=3)), Simulator(without, SimulatorSettings(seed=3))
    for _ in range(200):
        np.testing.assert_array_equal(one.step(inputs, H).position, other.step(inputs, H).position)
        np.testing.assert_array_equal(one.measure(), other.measure())
        one.measure_wind()
    np.testing.assert_array_equal(one.output.shaft_speed, other.output.shaft_speed)
    assert not one.truth().wind_force.any()


def test_gusts_leave_the_noise_of_other_sensors_alone() -> None:
    calm, windy = (
        Simulator(VESSEL, SimulatorSettings(seed=5, wind=wind))
        for wind in (WindSettings(), WindSettings(speed=1.0, gusts=True, direction_variation=0.1))
    )
    # At the start both lie in the same place: what differs would be noise.
    np.testing.assert_array_equal(calm.measure(), windy.measure())
    for sim in (calm, windy):
        for _ in range(50):
            sim.step(STILL, H)
            sim.measure_wind()
    noise = [np.array(sim.measure()) - sim.truth().position - sim.truth().wave_position for sim in (calm, windy)]
    # Sums of metres, in floating point.
    np.testing.assert_allclose(noise[0], noise[1], atol=1e-14)


def test_direction_wanders_with_its_standard_deviation() -> None:
    wind = Wind(VESSEL, WindSettings(speed=1.0, direction=1.0, direction_variation=0.2, time_constant=0.5), 9)
    found = []
    for _ in range(20_000):
        wind.advance(1.0)
        north, east = wind.velocity(0.0)
        found.append(math.atan2(east, north))
    # 20 000 samples with a correlation of exp(-2) each: the standard error of both is 0.002.
    assert np.mean(found) == pytest.approx(1.0, abs=0.008)
    assert np.std(found) == pytest.approx(0.2, abs=0.008)


def test_wind_on_a_vessel_without_wind_forces_is_refused() -> None:
    bare = VESSEL.model_copy(update={"wind_forces": None})
    with pytest.raises(InputError, match=r"wind\.speed: expected 0, .* no section wind_forces, found 2\.0 m/s"):
        simulator(vessel=bare, speed=2.0)
    sim = Simulator(bare)
    before = sim.settings
    with pytest.raises(InputError, match=r"wind\.speed"):
        sim.apply(before.model_copy(update={"wind": WindSettings(speed=2.0)}))
    assert sim.settings == before
    assert sim.measure_wind() is None


# Anemometer ----------------------------------------------------------------------------------------------------------


def test_anemometer_shows_the_air_relative_to_the_vessel() -> None:
    sim = simulator(speed=2.74, direction=2.0, gusts=True)
    sail(sim, 30.0)
    truth, measured = sim.truth(), sim.measure_wind()
    assert measured is not None
    assert np.abs(truth.velocity[:2]).max() > 0.01
    forces = VESSEL.wind_forces
    assert forces is not None
    # What it shows explains the force that acts.
    force = wind_force(forces.constants(), forces.table(), -measured[0], -measured[1])
    np.testing.assert_allclose(force, truth.wind_force, rtol=1e-12)


def test_in_head_wind_the_air_moves_astern() -> None:
    measured = simulator(speed=2.74).measure_wind()
    assert measured is not None
    assert measured[0] < 0.0
    assert measured[1] == pytest.approx(0.0, abs=1e-15)


def test_anemometer_noise_is_that_of_the_vessel_file() -> None:
    noisy = VESSEL.model_copy(
        update={
            "measurement": VESSEL.measurement.model_copy(update={"wind_speed_noise": 0.1, "wind_direction_noise": 0.05})
        }
    )
    sim = Simulator(noisy, SimulatorSettings(seed=1, wind=WindSettings(speed=2.74)))
    found = []
    for _ in range(2000):
        turn = sim.truth().position[2]
        measured = sim.measure_wind()
        assert measured is not None
        assert sim.measure_wind() is measured
        shown = complex(*measured) * np.exp(1j * turn)  # north + i east
        air = complex(*sim._wind.velocity(sim.time)) - complex(*sim.truth().velocity[:2]) * np.exp(1j * turn)
        found.append([abs(shown) - abs(air), np.angle(shown / air)])
        sim.step(STILL, H)
    # Standard error of a standard deviation of 2000 samples: 1.6 %.
    np.testing.assert_allclose(np.std(found, axis=0), [0.1, 0.05], rtol=0.07)
