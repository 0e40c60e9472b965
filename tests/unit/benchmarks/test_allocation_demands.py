"""Sequences that the allocator and its peers are given."""

import numpy as np
import pytest

from benchmarks.demands import demand_in_waves, is_saturated, record, saturated_share, sequence, starter, strength
from marine_model import load_vessel
from thrust_allocator import Allocator, AllocatorSettings

VESSEL = load_vessel("cybership3")


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_about_a_third_of_the_steps_is_saturated(mode: str) -> None:
    settings = AllocatorSettings(azimuth_mode=mode)
    found = sequence(VESSEL, starter(VESSEL, settings), 600, seed=3)
    # One halving of the amplitude more or less is a few steps.
    assert found.saturated == pytest.approx(1.0 / 3.0, abs=0.02)
    steps = record(VESSEL, settings, found.demands, found.dt)
    assert saturated_share(VESSEL, steps) == found.saturated


def test_a_seed_gives_one_sequence_and_another_seed_another() -> None:
    first, again, other = (demand_in_waves(VESSEL, 50, seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.allclose(first, other)


def test_steps_follow_from_one_another_and_keep_their_own_problem() -> None:
    settings = AllocatorSettings(azimuth_mode="rotating")
    demands = 0.5 * demand_in_waves(VESSEL, 30, 4)
    steps = record(VESSEL, settings, demands, 0.2)
    allocator = Allocator(VESSEL, settings)
    for before, step, tau in zip([None, *steps], steps, demands, strict=False):
        result = allocator.step(tau, 0.2)
        assert np.array_equal(step.thrust, result.thrust)
        assert np.array_equal(step.problem.tau, tau)
        assert allocator.problem is not None
        assert np.array_equal(step.problem.A, allocator.problem.A)
        if before is not None:
            assert np.array_equal(step.thrust_before, before.thrust)
            assert np.array_equal(step.azimuth_before, before.azimuth)


def test_a_step_is_saturated_by_any_axis() -> None:
    full = strength(VESSEL)
    for axis in range(3):
        slack = np.zeros(3)
        slack[axis] = -0.9e-4 * full[axis]
        assert not is_saturated(VESSEL, slack)
        slack[axis] = -1.1e-4 * full[axis]
        assert is_saturated(VESSEL, slack)
