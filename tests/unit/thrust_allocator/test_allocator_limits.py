"""No sequence of demands, settings and faults leads beyond the limits: properties of every step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import polar_configuration
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings, Phase, Status

VESSEL = load_vessel("cybership3")
C1 = VESSEL.allocator.approach_fraction
# What the issue asks for, N and rad.
LIMIT = 1e-9

SIZES = st.sampled_from([0.0, 0.01, 1.0, 5.0, 50.0, 1e6, 1e15])
NUMBERS = st.floats(-1.0, 1.0)


@st.composite
def demands(draw: st.DrawFn) -> FloatArray:
    tau = draw(SIZES) * np.array([draw(NUMBERS), draw(NUMBERS), draw(NUMBERS)])
    if draw(st.integers(0, 9)) == 0:
        tau[draw(st.integers(0, 2))] = draw(st.sampled_from([math.nan, math.inf, -math.inf]))
    return tau


@st.composite
def operator_settings(draw: st.DrawFn) -> AllocatorSettings:
    flags = st.tuples(*[st.sampled_from([True, True, True, False])] * 4)
    scales = st.tuples(*[st.sampled_from([1.0, 1.0, 0.7, 0.3, 1e-3, 0.0])] * 4)
    return AllocatorSettings(
        azimuth_mode=draw(st.sampled_from(["fixed", "rotating"])),
        thruster_enabled=draw(flags),
        azimuth_enabled=draw(flags),
        thrust_limit_scale=draw(scales),
    )


@dataclass(frozen=True)
class Leg:
    """Some steps with one demand and one set of settings."""

    settings: AllocatorSettings
    tau: FloatArray
    dt: float
    steps: int


LEGS = st.builds(
    Leg,
    operator_settings(),
    demands(),
    st.sampled_from([0.2, 0.2, 0.2, 0.02, 0.005, 0.3, 1e-4, 5.0]),
    st.integers(1, 12),
)


def check_step(
    allocator: Allocator, leg: Leg, thrust: FloatArray, azimuth: FloatArray, result: AllocationResult
) -> None:
    chosen = leg.settings
    dt = min(leg.dt, chosen.longest_step * VESSEL.measurement.sample_time)
    scale = np.array(chosen.thrust_limit_scale)
    enabled = np.array(chosen.thruster_enabled)
    step = VESSEL.thrust_rate * dt
    assert np.isfinite(result.thrust).all()
    assert np.isfinite(result.azimuth).all()

    # Rates, the azimuth the shorter way.
    assert (np.abs(result.thrust - thrust) <= step + LIMIT).all()
    assert (np.abs(wrap_angles(result.azimuth - azimuth)) <= VESSEL.azimuth_rate * dt + LIMIT).all()
    assert (result.azimuth >= -math.pi).all()
    assert (result.azimuth < math.pi).all()

    # Magnitudes: within the limits in force, or on the way back at c_1 of the rate or more.
    highest = np.maximum(scale * VESSEL.thrust_max, thrust - C1 * step)
    lowest = np.minimum(scale * VESSEL.thrust_min, thrust + C1 * step)
    lost = ~enabled
    highest[lost] = np.maximum(thrust - step, 0.0)[lost]
    lowest[lost] = np.minimum(thrust + step, 0.0)[lost]
    assert (result.thrust <= highest + LIMIT).all()
    assert (result.thrust >= lowest - LIMIT).all()

    # What rotates gives no reverse thrust; what may not turn does not.
    for j, phase in enumerate(result.phase):
        assert result.rotating[j] == (phase is Phase.ROTATING)
        if phase is Phase.ROTATING:
            assert chosen.azimuth_mode == "rotating"
            assert result.thrust[j] >= min(0.0, thrust[j] + step[j]) - LIMIT
        if not chosen.azimuth_enabled[j] or not VESSEL.can_rotate[j] or not enabled[j]:
            assert result.azimuth[j] == azimuth[j]

    # The sum, with the demand that was allocated.
    if np.isfinite(leg.tau).all():
        np.testing.assert_array_equal(result.tau_desired, leg.tau)
    B = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, result.azimuth)
    B[:, lost] = 0.0
    total = B @ result.thrust
    np.testing.assert_allclose(result.tau_achieved, total, rtol=0.0, atol=LIMIT)
    np.testing.assert_array_equal(result.slack, result.tau_desired - result.tau_achieved)
    # 1e-9 of a demand of ordinary size; adding 1e15 and taking it away again costs its rounding.
    rounding = 1e-15 * np.abs(result.tau_desired)
    assert (np.abs(total + result.slack - result.tau_desired) <= LIMIT + rounding).all()

    expected = Status.DEMAND_NOT_FINITE if not np.isfinite(leg.tau).all() else Status.OPTIMAL
    if not enabled.any() and expected is Status.OPTIMAL:
        expected = Status.NO_THRUSTER
    if leg.dt < 1e-3:
        # Windows of 1e-4 rad and 1e-3 N are lost in the arithmetic of demands far beyond the vessel.
        assert result.status in (expected, Status.HOLD), result.message
        return
    assert result.status is expected, result.message
    if enabled.any():
        assert allocator.solution is not None
        residuals = allocator.solution.residuals
        assert residuals.violation <= LIMIT
        assert max(residuals[1:]) <= 1e-8


@settings(max_examples=300, deadline=None)
@given(
    legs=st.lists(LEGS, min_size=1, max_size=6),
    share=st.tuples(*[st.floats(0.0, 1.0)] * 4),
    azimuth=st.tuples(*[st.floats(-math.pi, math.pi)] * 4),
)
def test_every_step_is_within_the_limits(legs: list[Leg], share: tuple[float, ...], azimuth: tuple[float, ...]) -> None:
    thrust = VESSEL.thrust_min + np.array(share) * (VESSEL.thrust_max - VESSEL.thrust_min)
    allocator = Allocator(VESSEL, legs[0].settings, thrust, azimuth)
    before = thrust, np.where(VESSEL.can_rotate, wrap_angles(np.array(azimuth)), VESSEL.fixed_direction)
    for leg in legs:
        allocator.apply(leg.settings)
        for _ in range(leg.steps):
            result = allocator.step(leg.tau, leg.dt)
            check_step(allocator, leg, *before, result)
            before = result.thrust, result.azimuth


@settings(max_examples=50, deadline=None)
@given(
    start=st.tuples(*[st.floats(-200.0, 200.0)] * 4),
    azimuth=st.tuples(*[st.floats(-10.0, 10.0)] * 4),
    mode=st.sampled_from(["fixed", "rotating"]),
    tau=demands(),
)
def test_operating_point_beyond_the_limits_is_led_back(
    start: tuple[float, ...], azimuth: tuple[float, ...], mode: str, tau: FloatArray
) -> None:
    """Feedback of a windmilling or overloaded thruster may say anything; (4.14)-(4.15) lead back at c_1 and more."""
    dt = 0.2
    allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode=mode), start, azimuth)
    step = VESSEL.thrust_rate * dt
    worst = np.maximum(np.array(start) - VESSEL.thrust_max, VESSEL.thrust_min - np.array(start))
    needed = int(max(np.ceil((worst / (C1 * step)).max()), 0.0))
    thrust = np.array(start)
    for _ in range(needed + 1):
        result = allocator.step(tau, dt)
        assert result.status in (Status.OPTIMAL, Status.DEMAND_NOT_FINITE), result.message
        assert (np.abs(result.thrust - thrust) <= step + LIMIT).all()
        thrust = result.thrust
    assert (thrust <= VESSEL.thrust_max + LIMIT).all()
    assert (thrust >= VESSEL.thrust_min - LIMIT).all()
