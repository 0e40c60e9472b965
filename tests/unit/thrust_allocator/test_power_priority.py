"""Yaw served before surge and sway when power is short, [Ruth] 4.4.3."""

from __future__ import annotations

import math

import daqp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from marine_model import load_vessel
from marine_model.thruster_configuration import polar_configuration
from thrust_allocator.cost import propeller_weights, reweight, thrust_floor
from thrust_allocator.power import PowerStage, limit_total_power, total_power

VESSEL = load_vessel("cybership3")
M = VESSEL.propellers.power_per_thrust_3_2
B = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, VESSEL.fixed_direction)
WEIGHT = propeller_weights(M)
FLOOR = thrust_floor(VESSEL.thrust_min, VESSEL.thrust_max)
GAMMA = VESSEL.allocator.slack_gain


class FixedAllocator:
    """Fixed directions, thrust limits, no rates; quadratic or power-true. Yaw starts with the weight of the others."""

    def __init__(self, rounds: int) -> None:
        self.rounds = rounds
        self.factors: list[float] = []

    def __call__(self, tau: np.ndarray, yaw_weight_factor: float) -> tuple[float, np.ndarray]:
        self.factors.append(yaw_weight_factor)
        slack = (GAMMA * np.array([1.0, 1.0, yaw_weight_factor])) ** 2
        weight, thrust = WEIGHT.copy(), np.zeros(4)
        for _ in range(self.rounds):
            hessian = (B.T * slack) @ B + np.diag(weight)
            thrust, _, flag, _ = daqp.solve(
                hessian,
                -(B.T * slack) @ tau,
                np.zeros((0, 4)),
                VESSEL.thrust_max.copy(),
                VESSEL.thrust_min.copy(),
                np.zeros(4, dtype=np.int32),
            )
            assert flag == 1
            reweight(WEIGHT, np.ones(4), thrust, FLOOR, weight)
        return total_power(M, thrust), thrust


demands = arrays(np.float64, 3, elements=st.floats(-12.0, 12.0))


@pytest.mark.parametrize("rounds", [1, 12])
@given(tau=demands, share=st.floats(0.0, 1.2), yaw_priority=st.booleans())
def test_the_answer_fits_in_eight_calls(rounds: int, tau: np.ndarray, share: float, yaw_priority: bool) -> None:
    allocate = FixedAllocator(rounds)
    demanded, _ = allocate(tau, 1.0)
    available = share * demanded
    answer = limit_total_power(allocate, tau, available, yaw_priority=yaw_priority)
    assert answer.calls == len(allocate.factors) - 1 <= 8
    assert answer.demanded == pytest.approx(demanded)
    power = total_power(M, answer.phase_back * answer.commands)
    assert power <= available * (1.0 + 1e-12) + 1e-300  # numbers below that have few digits
    assert answer.power == pytest.approx(power, rel=1e-9, abs=1e-12)
    assert 0.0 <= answer.phase_back <= 1.0
    assert 0.0 <= answer.surge_sway_scale <= 1.0
    if demanded <= available:
        assert answer.stage is PowerStage.WITHIN
    if not yaw_priority:
        assert answer.stage in (PowerStage.WITHIN, PowerStage.PHASE_BACK)


def test_yaw_weight_alone_does_nothing_while_nothing_saturates() -> None:
    """The slack is next to zero in every axis, so that its weights have nothing to decide."""
    tau = np.array([4.0, 2.0, 1.0])
    allocate = FixedAllocator(12)
    (one, a), (other, b) = allocate(tau, 1.0), allocate(tau, 100.0)
    np.testing.assert_allclose(a, b, atol=1e-5)  # the slack itself, about 1 / gamma^2 of the demand
    assert one == pytest.approx(other, rel=1e-5)
    assert limit_total_power(allocate, tau, 0.9 * one).stage is PowerStage.SURGE_SWAY_SCALED


def test_yaw_is_kept_while_surge_and_sway_give_way() -> None:
    tau = np.array([6.0, 2.0, 1.0])
    allocate = FixedAllocator(12)
    whole, _ = allocate(tau, 1.0)
    yaw_alone, _ = allocate(np.array([0.0, 0.0, 1.0]), 1.0)
    assert yaw_alone < 0.5 * whole
    for share in (0.95, 0.75, 0.55):
        answer = limit_total_power(allocate, tau, share * whole)
        assert answer.stage is PowerStage.SURGE_SWAY_SCALED
        v = answer.surge_sway_scale
        np.testing.assert_allclose(B @ answer.commands, [6.0 * v, 2.0 * v, 1.0], atol=1e-4)
        assert answer.power == pytest.approx(share * whole, rel=0.01)  # little is left unused
    answer = limit_total_power(allocate, tau, 0.5 * yaw_alone)
    assert answer.stage is PowerStage.PHASE_BACK
    assert answer.surge_sway_scale == 0.0
    achieved = B @ (answer.phase_back * answer.commands)
    np.testing.assert_allclose(achieved, [0.0, 0.0, 0.5 ** (2.0 / 3.0)], atol=1e-4)


def test_yaw_weight_answers_in_saturation() -> None:
    """More sway and yaw than there is: with a larger weight on yaw less power is spent on what cannot be met."""
    allocate = FixedAllocator(12)
    found = 0
    rng = np.random.default_rng(3)
    for _ in range(200):
        tau = rng.uniform(-1.0, 1.0, 3) * (20.0, 20.0, 15.0)
        plain, _ = allocate(tau, 1.0)
        raised, _ = allocate(tau, 10.0)
        if raised < 0.98 * plain:
            answer = limit_total_power(allocate, tau, 0.5 * (plain + raised))
            assert answer.stage is PowerStage.YAW_WEIGHT
            assert answer.power == pytest.approx(raised)
            found += 1
    assert found > 10


def test_continuous_in_what_is_available() -> None:
    tau = np.array([6.0, -3.0, 1.5])
    allocate = FixedAllocator(12)
    yaw_alone, _ = allocate(np.array([0.0, 0.0, 1.5]), 10.0)
    answers = [limit_total_power(allocate, tau, yaw_alone * (1.0 + d)) for d in (-1e-6, 1e-6)]
    assert [answer.stage for answer in answers] == [PowerStage.PHASE_BACK, PowerStage.SURGE_SWAY_SCALED]
    forces = [B @ (answer.phase_back * answer.commands) for answer in answers]
    np.testing.assert_allclose(forces[0], forces[1], atol=0.01)


@pytest.mark.parametrize("available", [0.0, math.inf])
def test_no_power_and_no_limit(available: float) -> None:
    answer = limit_total_power(FixedAllocator(1), np.array([3.0, 1.0, 0.5]), available)
    if available == 0.0:
        assert answer.power == 0.0
        assert (answer.phase_back * answer.commands == 0.0).all()
    else:
        assert answer.stage is PowerStage.WITHIN


def test_without_a_larger_yaw_weight_its_step_is_left_out() -> None:
    allocate = FixedAllocator(1)
    limit_total_power(allocate, np.array([6.0, 2.0, 1.0]), 1.0, yaw_weight_factor=1.0)
    assert set(allocate.factors) == {1.0}


@pytest.mark.parametrize(("exponent", "left"), [(0.4, 0.1), (1.0, 0.01), (1.5, 0.01), (3.0, 0.05), (6.0, 0.1)])
def test_power_of_any_shape_is_found(exponent: float, left: float) -> None:
    """Power as any rising function of v, convex or not: never above what there is, and most of v is found."""

    def allocate(tau: np.ndarray, factor: float) -> tuple[float, float]:
        return 1.0 + 9.0 * float(tau[0]) ** exponent, float(tau[0])

    for available in np.linspace(1.0, 9.9, 30):
        answer = limit_total_power(allocate, np.array([1.0, 0.0, 1.0]), float(available))
        assert answer.power <= available
        exact = ((available - 1.0) / 9.0) ** (1.0 / exponent)
        # Bisection would leave 1/32 of v after the five calls that remain, and be no better on straight lines.
        assert exact - left <= answer.surge_sway_scale <= exact * (1.0 + 1e-12)


def test_how_well_the_power_is_used() -> None:
    """Over random demands and limits, whenever surge and sway are scaled."""
    rng = np.random.default_rng(5)
    allocate = FixedAllocator(12)
    used, calls = [], []
    for _ in range(300):
        tau = rng.normal(size=3) * (4.0, 3.0, 1.5)
        whole, _ = allocate(tau, 1.0)
        available = rng.uniform(0.2, 1.0) * whole
        answer = limit_total_power(allocate, tau, available)
        if answer.stage is PowerStage.SURGE_SWAY_SCALED:
            used.append(answer.power / available)
            calls.append(answer.calls)
    # Measured: 254 cases; 99.75 % used in the median, 96.9 % in the worst hundredth, 94.2 % at least; 6 calls.
    assert len(used) > 200
    assert np.median(used) > 0.995
    assert min(used) > 0.9
    assert np.median(calls) <= 6


def test_yaw_alone_may_take_more_than_yaw_with_some_sway() -> None:
    """Then less than what yaw alone takes is enough for all of yaw; below that, u begins at 1."""
    allocate = FixedAllocator(12)
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(200):
        tau = rng.normal(size=3) * (4.0, 3.0, 1.5)
        powers = [allocate(np.array([v * tau[0], v * tau[1], tau[2]]), 10.0)[0] for v in np.linspace(0.0, 1.0, 11)]
        if powers[0] > 1.01 * min(powers) and powers[-1] > powers[0]:
            found += 1
            between = limit_total_power(allocate, tau, 0.5 * (powers[0] + min(powers)))
            assert between.stage is PowerStage.SURGE_SWAY_SCALED
            assert (B @ between.commands)[2] == pytest.approx(tau[2], abs=1e-4)
            below = limit_total_power(allocate, tau, 0.9 * min(powers))  # the grid of v misses the least by less
            assert below.stage is PowerStage.PHASE_BACK
            assert below.surge_sway_scale > 0.0
            # 0.9^(2/3) = 0.932 at the v of least power; the parabola is not exactly there.
            assert below.phase_back > 0.92
    assert found >= 10


@given(
    steps=st.lists(st.floats(0.0, 100.0), min_size=12, max_size=12),
    available=st.floats(0.0, 100.0),
)
def test_any_power_whatever_is_answered_within_the_limit(steps: list[float], available: float) -> None:
    """Jumps, plateaus, power that falls as v rises."""

    def allocate(tau: np.ndarray, factor: float) -> tuple[float, float]:
        power = steps[min(int(10.0 * float(tau[0])), 10)] if factor > 1.0 else steps[11]
        return power, power

    answer = limit_total_power(allocate, np.array([1.0, 0.0, 1.0]), available)
    assert answer.phase_back**1.5 * answer.commands <= available * (1.0 + 1e-9)
    assert answer.calls <= 8
