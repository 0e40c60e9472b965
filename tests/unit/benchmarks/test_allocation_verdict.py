"""What is counted as a limit broken, by hand."""

import numpy as np
import pytest

from benchmarks.demands import demand_in_waves, record
from benchmarks.reference import optima
from benchmarks.verdict import TOLERANCE, judge
from marine_model import load_vessel
from thrust_allocator import AllocatorSettings

VESSEL = load_vessel("cybership3")
STEPS = record(VESSEL, AllocatorSettings(azimuth_mode="rotating"), demand_in_waves(VESSEL, 30, 2), 0.2)
OPTIMUM = [step.problem.B @ z for step, z in zip(STEPS, optima([step.problem for step in STEPS]), strict=True)]
LAST = len(STEPS) - 1  # thrust is up there, so that directions count


def _with(thrust: float = 0.0, azimuth: float = 0.0, j: int = 2):
    step = STEPS[LAST]
    one, two = step.thrust.copy(), step.azimuth.copy()
    one[j] += thrust
    two[j] += azimuth
    return one, two


def test_the_allocators_own_answers_break_nothing() -> None:
    verdict = judge(VESSEL, STEPS, OPTIMUM, range(len(STEPS)), [(s.thrust, s.azimuth) for s in STEPS])
    assert (verdict.steps, verdict.failures, verdict.bad_steps) == (len(STEPS), 0, 0)
    assert max(verdict.thrust.largest, verdict.thrust_rate.largest, verdict.azimuth_rate.largest) < 1e-12


def test_too_much_thrust_counts_by_its_excess() -> None:
    more = float(VESSEL.thrust_max[2] - STEPS[LAST].thrust[2]) + 0.5
    verdict = judge(VESSEL, STEPS, OPTIMUM, [LAST], [_with(thrust=more)])
    assert verdict.thrust.largest == pytest.approx(0.5)
    assert (verdict.thrust.count, verdict.bad_steps) == (1, 1)
    assert verdict.thrust_rate.count == 1  # nor can it have got there in one step
    # All of it goes into the force, along the thruster's direction.
    assert verdict.force_errors[0] > 0.5 * more


def test_turning_too_fast_counts_by_its_excess() -> None:
    step = STEPS[LAST]
    turn = float(VESSEL.azimuth_rate[2]) * step.dt + 0.3 - float(step.azimuth[2] - step.azimuth_before[2])
    verdict = judge(VESSEL, STEPS, OPTIMUM, [LAST], [_with(azimuth=turn)])
    width = VESSEL.allocator.zero_region * float(VESSEL.thrust_max[2] - VESSEL.thrust_min[2])
    assert verdict.azimuth_rate.largest == pytest.approx(0.3 - np.arcsin(width / step.thrust[2]))
    assert (verdict.azimuth_rate.count, verdict.bad_steps, verdict.thrust_rate.count) == (1, 1, 0)


def test_less_than_the_tolerance_is_told_and_not_counted() -> None:
    more = float(VESSEL.thrust_max[2]) - float(STEPS[LAST].thrust[2]) + 0.9 * TOLERANCE
    verdict = judge(VESSEL, STEPS, OPTIMUM, [LAST], [_with(thrust=more)])
    assert verdict.thrust.largest == pytest.approx(0.9 * TOLERANCE)
    assert verdict.thrust.count == 0


def test_no_answer_is_a_failure() -> None:
    verdict = judge(VESSEL, STEPS, OPTIMUM, [0, 1], [None, (STEPS[1].thrust, STEPS[1].azimuth)])
    assert (verdict.steps, verdict.failures, verdict.bad_steps) == (2, 1, 1)
    assert str(verdict).startswith("1 of 2 failed; limits broken")


def test_who_does_not_know_the_thrusters_is_judged_by_its_own_course() -> None:
    far = [(s.thrust * 0.0, s.azimuth + 1.0) for s in STEPS[-2:]]
    by_step = judge(VESSEL, STEPS, OPTIMUM, [LAST - 1, LAST], far)
    by_own = judge(VESSEL, STEPS, OPTIMUM, [LAST - 1, LAST], far, own_course=True)
    assert by_step.thrust_rate.count == 2
    assert by_own.thrust_rate.count == 0
