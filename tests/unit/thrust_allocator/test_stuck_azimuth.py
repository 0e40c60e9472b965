"""A lost azimuth drive is allocated where it was measured; the measure of auto is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.settings import with_parameters
from thrust_allocator import Allocator, AllocatorSettings

VESSEL = load_vessel("cybership3")
SETTINGS = AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating")
STUCK = {"azimuth_enabled": [True, True, True, False]}
DT = 0.2
STEP = float(VESSEL.azimuth_rate[3]) * DT
DEMAND = (1.0, 0.0, 0.0)


def started() -> Allocator:
    allocator = Allocator(VESSEL, SETTINGS)
    for _ in range(50):
        allocator.step(DEMAND, DT)
    return allocator


def commanded_starboard(allocator: Allocator) -> float:
    assert allocator.answer is not None
    return float(allocator.answer.commands[3, 1])


def test_the_command_goes_to_where_it_sticks_at_the_rate_of_the_drive_and_stays() -> None:
    allocator = started()
    allocator.apply(with_parameters(SETTINGS, STUCK))
    commanded = commanded_starboard(allocator)
    sticks = commanded + 2.5 * STEP
    found = []
    for _ in range(5):
        allocator.measure_azimuth([0.1, 0.2, 0.3, sticks])
        result = allocator.step(DEMAND, DT)
        found.append(float(result.azimuth[3]) - commanded)
    assert found == pytest.approx([STEP, 2.0 * STEP, 2.5 * STEP, 2.5 * STEP, 2.5 * STEP])
    # The others turn as they like, and the demand is met with the thruster where it really points.
    assert result.tau_achieved == pytest.approx(DEMAND, abs=1e-3)
    x = result.thrust * np.cos(result.azimuth)
    assert x.sum() == pytest.approx(1.0, abs=1e-3)


def test_it_takes_the_shorter_way() -> None:
    allocator = Allocator(VESSEL, with_parameters(SETTINGS, STUCK), azimuth=[math.pi / 2, 0.0, 0.0, 3.1])
    allocator.measure_azimuth([0.0, 0.0, 0.0, -3.1])
    assert float(allocator.step(DEMAND, DT).azimuth[3]) == pytest.approx(-3.1)


def test_noise_about_where_it_was_commanded_to_moves_no_command() -> None:
    """A sound drive that is held follows its command: one that followed the measurement would walk away with it."""
    allocator = started()
    allocator.apply(with_parameters(SETTINGS, STUCK))
    commanded = commanded_starboard(allocator)
    within = 0.9 * VESSEL.drivers.azimuth.threshold
    for off in (within, -within, within):
        allocator.measure_azimuth([0.0, 0.0, 0.0, commanded + off])
        assert float(allocator.step(DEMAND, DT).azimuth[3]) == commanded


def test_without_a_measurement_it_counts_as_where_it_was_commanded_to() -> None:
    allocator = started()
    allocator.apply(with_parameters(SETTINGS, STUCK))
    commanded = commanded_starboard(allocator)
    assert [float(allocator.step(DEMAND, DT).azimuth[3]) for _ in range(3)] == [commanded] * 3


def test_a_measurement_has_no_say_over_thrusters_that_turn_and_is_forgotten_with_the_repair() -> None:
    free, told = started(), started()
    told.measure_azimuth([0.5, 1.0, 2.0, -2.0])
    for _ in range(3):
        assert np.array_equal(free.step(DEMAND, DT).commands, told.step(DEMAND, DT).commands)
    told.apply(with_parameters(SETTINGS, STUCK))
    told.measure_azimuth([0.5, 1.0, 2.0, -2.0])
    told.step(DEMAND, DT)
    told.apply(SETTINGS)
    told.step(DEMAND, DT)
    told.apply(with_parameters(SETTINGS, STUCK))
    commanded = commanded_starboard(told)
    assert float(told.step(DEMAND, DT).azimuth[3]) == commanded


@pytest.mark.parametrize(
    ("azimuth", "message"),
    [([0.0, 0.0], r"azimuth: expected shape \(4,\)"), ([0.0, 0.0, 0.0, math.nan], "azimuth: expected finite")],
)
def test_a_bad_measurement_is_refused(azimuth: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        started().measure_azimuth(azimuth)


def test_directions_are_needed_while_a_drive_is_lost() -> None:
    assert not SETTINGS.needs_direction
    assert not AllocatorSettings().needs_direction
    assert with_parameters(SETTINGS, STUCK).needs_direction
    assert with_parameters(SETTINGS, {"azimuth_rate_scale": [1.0, 1.0, 0.0, 1.0]}).needs_direction


def test_the_measure_of_auto_is_told_in_auto_alone() -> None:
    allocator = started()
    assert math.isnan(allocator.step(DEMAND, DT).mean_force)
    auto = with_parameters(SETTINGS, {"azimuth_mode": "auto"})
    allocator = Allocator(VESSEL, auto)
    rate = auto.auto.filter_frequency
    for k in range(1, 4):
        # (6.3) for a demand of sqrt(3^2 + 4^2) since the start
        assert allocator.step((3.0, 4.0, 9.0), DT).mean_force == pytest.approx(5.0 * -math.expm1(-rate * k * DT))
