"""Current that varies slowly: statistics, continuity of the velocity over ground, seeds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from marine_model import load_vessel
from vessel_sim import CurrentSettings, Simulator, SimulatorInputs, SimulatorSettings
from vessel_sim.current import Current
from vessel_sim.slow_variation import SlowVariation

VESSEL = load_vessel("cybership3")
H = VESSEL.simulation.time_step
STILL = SimulatorInputs(np.zeros(4), np.zeros(4))


def simulator(seed: int = 1, **current: Any) -> Simulator:
    return Simulator(VESSEL, SimulatorSettings(seed=seed, sensor_noise=False, current=CurrentSettings(**current)))


@pytest.mark.parametrize("dt", [0.1, 0.5, 3.0])
def test_variation_is_exact_for_any_step(dt: float) -> None:
    """Unit variance and a correlation of exp(-dt / T), however coarse the step."""
    process = SlowVariation(3, "current", 50)
    rows = []
    for _ in range(4000):
        process.advance(dt, 1.0)
        rows.append(process.values)
    x = np.array(rows)
    # 200 000 samples, those of dt = 0.1 worth 10 000: standard error of the variance 1.4 %, of the correlation less.
    assert (x**2).mean() == pytest.approx(1.0, abs=0.05)
    assert (x[1:] * x[:-1]).mean() / (x**2).mean() == pytest.approx(math.exp(-dt), abs=0.01)


def test_it_begins_as_it_goes_on() -> None:
    starts = [SlowVariation(seed, "current", 1).values[0] for seed in range(2000)]
    # Standard errors 0.022 and 0.016.
    assert np.mean(starts) == pytest.approx(0.0, abs=0.08)
    assert np.std(starts) == pytest.approx(1.0, abs=0.06)


def test_current_has_the_mean_and_deviations_that_are_asked_for() -> None:
    settings = CurrentSettings(speed=0.5, direction=1.0, variation=0.05, direction_variation=0.1, time_constant=1.0)
    current = Current(settings, 7)
    found = []
    for _ in range(10_000):
        assert current.advance(2.0)
        north, east = current.velocity
        found.append([math.hypot(north, east), math.atan2(east, north)])
    # 10 000 samples with a correlation of exp(-2): standard errors 0.0006 and 0.0012 for the means, 0.0004 and 0.0008.
    np.testing.assert_allclose(np.mean(found, axis=0), [0.5, 1.0], atol=0.005)
    np.testing.assert_allclose(np.std(found, axis=0), [0.05, 0.1], atol=0.004)


def test_velocity_over_ground_does_not_jump() -> None:
    calm = simulator(speed=0.2, direction=0.7)
    wild = simulator(speed=0.2, direction=0.7, variation=0.1, direction_variation=0.3, time_constant=0.5)
    largest = 0.0
    for sim in (calm, wild):
        before = sim.output.velocity
        for _ in range(500):
            after = sim.step(STILL, H).velocity
            largest = max(largest, float(np.abs(after[:2] - before[:2]).max()))
            before = after
    current = Current(wild.settings.current, 1)
    jumps = []
    for _ in range(500):
        old = np.array(current.velocity)
        current.advance(H)
        jumps.append(np.abs(np.array(current.velocity) - old).max())
    # The current moves by some cm/s in a step; the vessel, which is heavy, by less than a tenth of that.
    assert max(jumps) > 0.03
    assert largest < 0.1 * max(jumps)


def test_current_of_the_truth_is_that_of_the_step() -> None:
    sim = simulator(speed=0.2, direction=0.7, variation=0.05, time_constant=5.0)
    seen = []
    for _ in range(10):
        sim.step(STILL, H)
        truth = sim.truth()
        seen.append(truth.current)
        relative = np.array(sim._relative[:2])
        c, s = math.cos(truth.position[2]), math.sin(truth.position[2])
        over_ground = relative + np.array([[c, s], [-s, c]]) @ truth.current
        np.testing.assert_allclose(truth.velocity[:2], over_ground, atol=1e-15)
    assert len({tuple(row) for row in seen}) == 10


def test_without_variation_nothing_changes_to_the_bit() -> None:
    """The slow variation has random numbers of its own, and none are used."""
    plain, other = simulator(speed=0.2, direction=0.7), simulator(speed=0.2, direction=0.7, time_constant=3.0)
    for _ in range(100):
        np.testing.assert_array_equal(plain.step(STILL, H).position, other.step(STILL, H).position)


def test_seed_decides() -> None:
    def drift(seed: int) -> list[float]:
        sim = simulator(seed, speed=0.2, variation=0.05, direction_variation=0.2, time_constant=5.0)
        for _ in range(100):
            sim.step(STILL, H)
        return [float(value) for value in sim.output.position]

    assert drift(1) == drift(1)
    assert drift(1) != drift(2)
