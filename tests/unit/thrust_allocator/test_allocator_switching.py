"""Fixed to rotating and back: [Ruth] 6.3."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model import Vessel, load_vessel
from marine_model.frames import wrap_angle, wrap_angles
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings, Phase, Status

VESSEL = load_vessel("cybership3")
DT = 0.2
TURN = 1.05 * DT
FIXED = AllocatorSettings(azimuth_mode="fixed")
ROTATING = AllocatorSettings(azimuth_mode="rotating")
SPAN = VESSEL.thrust_max - VESSEL.thrust_min
ZERO = 0.001 * SPAN  # c_2 (|T_max| + |T_min|)


def run(allocator: Allocator, tau: list[float], steps: int) -> list[AllocationResult]:
    return [allocator.step(tau, DT) for _ in range(steps)]


def test_to_fixed_turns_at_full_rate_and_is_allocated_as_fixed_on_the_way() -> None:
    allocator = Allocator(VESSEL, ROTATING)
    before = run(allocator, [-4.0, 1.0, 0.0], 60)[-1]
    rest = wrap_angles(VESSEL.fixed_direction - before.azimuth)
    assert np.abs(rest[1:]).min() > 3 * TURN  # all azimuth thrusters have a way to go
    allocator.apply(FIXED)
    steps = int(np.ceil(np.abs(rest[1:]).max() / TURN))
    previous = before
    for k in range(1, steps + 1):
        result = allocator.step([-4.0, 1.0, 0.0], DT)
        assert result.status is Status.OPTIMAL
        assert result.rotating == (False,) * 4
        for j in (1, 2, 3):
            left = max(abs(rest[j]) - k * TURN, 0.0)
            assert abs(wrap_angle(VESSEL.fixed_direction[j] - result.azimuth[j])) == pytest.approx(left, abs=1e-12)
            turning = abs(rest[j]) > (k - 1) * TURN
            assert result.phase[j] is (Phase.TURNING if turning else Phase.FIXED)
            assert result.azimuth_saturated[j] == turning
        # Allocated along the directions of this very step: the demand is met as far as thrust rates allow.
        problem = allocator.problem
        assert problem is not None
        np.testing.assert_allclose(problem.B[0], np.cos(result.azimuth), atol=1e-15)
        previous = result
    np.testing.assert_array_equal(previous.azimuth, [wrap_angle(a) for a in VESSEL.fixed_direction])
    assert run(allocator, [-4.0, 1.0, 0.0], 10)[-1].thrust.min() < -1.0  # reverse thrust is there again


def test_fixed_directions_may_be_others_than_those_of_the_vessel_file() -> None:
    allocator = Allocator(VESSEL, FIXED)
    angles = tuple(np.radians([0.0, 80.0, 26.0, 46.0]).tolist())
    allocator.apply(AllocatorSettings(azimuth_mode="fixed", fixed_direction=angles))
    first = allocator.step([1.0, 0.0, 0.0], DT)
    # The starboard thruster has 91 deg to turn, and does so at full rate; the tunnel thruster keeps its own direction.
    assert first.azimuth[3] == pytest.approx(VESSEL.fixed_direction[3] + TURN)
    last = run(allocator, [1.0, 0.0, 0.0], 10)[-1]
    assert last.azimuth == pytest.approx([VESSEL.fixed_direction[0], *angles[1:]])
    assert last.tau_achieved == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
    allocator.apply(FIXED)
    assert run(allocator, [1.0, 0.0, 0.0], 12)[-1].azimuth == pytest.approx(VESSEL.fixed_direction)


def test_to_rotating_stays_fixed_until_reverse_thrust_is_gone() -> None:
    allocator = Allocator(VESSEL, FIXED)
    before = run(allocator, [-6.0, 0.0, 0.0], 30)[-1]
    reversing = before.thrust < -1.0
    assert reversing.tolist() == [False, False, True, True]
    allocator.apply(ROTATING)
    held = 0
    for _ in range(40):
        result = allocator.step([-6.0, 0.0, 0.0], DT)
        assert result.status is Status.OPTIMAL
        for j in (2, 3):
            if before.thrust[j] < -ZERO[j] * (1.0 + 1e-6):
                held += 1
                assert result.phase[j] is Phase.HELD
                assert result.azimuth[j] == before.azimuth[j]
                # Back at c_1 of the rate or more, and no further than the new limit asks for.
                least = before.thrust[j] + 0.9 * VESSEL.thrust_rate[j] * DT
                assert result.thrust[j] >= min(least, -ZERO[j]) - 1e-9
            else:
                assert result.phase[j] is Phase.ROTATING
                assert result.thrust[j] >= 0.0
        before = result
    assert held >= 2  # "in the order of a few time steps"
    assert result.tau_achieved == pytest.approx([-6.0, 0.0, 0.0], abs=1e-3)


def test_a_thruster_wanted_the_other_way_round_is_released() -> None:
    """At -c_2 (|T_max| + |T_min|) exactly, "T_0 > limit" as printed would never come true."""
    allocator = Allocator(VESSEL, FIXED)
    thrust = run(allocator, [-6.0, 0.0, 0.0], 30)[-1].thrust
    allocator.apply(ROTATING)
    on_limit = False
    for _ in range(20):
        result = allocator.step([-6.0, 0.0, 0.0], DT)
        on_limit |= any(
            phase is Phase.HELD and value == -limit
            for phase, value, limit in zip(result.phase, result.thrust, ZERO, strict=True)
        )
        thrust = result.thrust
    assert on_limit
    assert result.rotating == (False, True, True, True)
    assert (thrust[1:] >= 0.0).all()


def test_thrusters_may_be_in_different_phases() -> None:
    chosen = AllocatorSettings(
        azimuth_mode="rotating", azimuth_enabled=(True, False, True, True), thruster_enabled=(False, True, True, True)
    )
    allocator = Allocator(VESSEL, chosen, thrust=[0.5, -2.0, -5.0, 4.0], azimuth=[0.0, 2.0, 0.1, -2.5])
    result = allocator.step([3.0, 1.0, 0.5], DT)
    assert result.phase == (Phase.LOST, Phase.FIXED, Phase.HELD, Phase.ROTATING)
    assert result.azimuth[0] == pytest.approx(math.pi / 2)  # a tunnel thruster keeps its own direction
    assert result.azimuth[1] == pytest.approx(2.0)
    assert result.azimuth[2] == pytest.approx(0.1)
    allocator.apply(FIXED)
    result = allocator.step([3.0, 1.0, 0.5], DT)
    assert result.phase == (Phase.FIXED, Phase.TURNING, Phase.TURNING, Phase.TURNING)


def test_switching_to_and_fro_every_step_stays_feasible() -> None:
    random = np.random.default_rng(3)
    allocator = Allocator(VESSEL, FIXED)
    for k in range(600):
        allocator.apply(ROTATING if k % 2 else FIXED)
        assert allocator.step(random.normal(size=3) * [6.0, 4.0, 3.0], DT).status is Status.OPTIMAL


@pytest.mark.parametrize("start", [math.pi / 2, -math.pi / 2, 0.0, math.pi / 2 - TURN, 2.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_idle_thrusters_turn_round_from_any_direction(start: float, way: float) -> None:
    """Rotation with zero thrust; (4.38)-(4.39) as printed leave no room for it at 90 deg."""
    chosen = AllocatorSettings(azimuth_mode="rotating", thruster_enabled=(False, False, True, True))
    allocator = Allocator(VESSEL, chosen, azimuth=[0.0, 0.0, start, start])
    wanted = wrap_angle(start + way * 0.9 * math.pi)
    tau = [4.0 * math.cos(wanted), 4.0 * math.sin(wanted), -0.81 * 4.0 * math.sin(wanted)]
    # Either way round, and the thrust after it.
    for _ in range(math.ceil(1.1 * math.pi / TURN) + 5):
        result = allocator.step(tau, DT)
        assert (result.thrust >= 0.0).all()
    # Weights of 0.85 and 0.87 share the force unevenly; the directions make up for the moment of that.
    np.testing.assert_allclose(wrap_angles(result.azimuth[2:] - wanted), 0.0, atol=0.02)
    np.testing.assert_allclose(result.tau_achieved, tau, atol=1e-3)


@given(start=st.floats(-math.pi, math.pi), offset=st.floats(0.05, 0.98), way=st.sampled_from([-1.0, 1.0]))
@settings(max_examples=100, deadline=None)
def test_an_idle_thruster_turns_the_shorter_way(start: float, offset: float, way: float) -> None:
    """Judged without yaw, which weighs sway more than surge for a thruster far aft."""
    document = VESSEL.model_dump()
    document["allocator"]["slack_weight"] = (1.0, 1.0, 1e-9)
    only = AllocatorSettings(azimuth_mode="rotating", thruster_enabled=(False, False, True, False))
    allocator = Allocator(Vessel.model_validate(document), only, azimuth=[0.0, 0.0, start, 0.0])
    angle = offset * math.pi
    wanted = start + way * angle
    for k in range(1, math.ceil(angle / TURN) + 6):
        result = allocator.step([2.0 * math.cos(wanted), 2.0 * math.sin(wanted), 0.0], DT)
        turned = way * wrap_angle(result.azimuth[2] - start)
        # Lines 6 and 7 in Figure 4.3 let the direction lag while the thrust rises; it never turns the wrong way.
        assert -1e-6 <= turned <= min(angle, k * TURN) + 1e-6
        if angle - k * TURN > 0.5 * math.pi:  # nothing to be gained but by turning
            assert turned == pytest.approx(k * TURN)
            assert result.thrust[2] == 0.0
    assert turned == pytest.approx(angle, abs=1e-5)
    assert result.thrust[2] == pytest.approx(2.0, abs=1e-5)


def test_no_demand_leaves_directions_alone() -> None:
    allocator = Allocator(VESSEL, ROTATING)
    run(allocator, [3.0, 2.0, 0.5], 30)
    run(allocator, [0.0, 0.0, 0.0], 30)
    before = allocator.step([0.0, 0.0, 0.0], DT)
    after = run(allocator, [0.0, 0.0, 0.0], 50)[-1]
    np.testing.assert_array_equal(after.azimuth, before.azimuth)
    np.testing.assert_allclose(after.thrust, 0.0, atol=1e-6)


# Steps of the joystick in the manner of Figure 4.7: surge, sway, yaw, one at a time and together, both ways.
JOYSTICK = [
    [3.0, 0.0, 0.0],
    [-3.0, 0.0, 0.0],
    [0.0, 3.0, 0.0],
    [0.0, -3.0, 0.0],
    [0.0, 0.0, 1.5],
    [0.0, 0.0, -1.5],
    [3.0, 2.0, 0.5],
    [-3.0, -2.0, -0.5],
    [0.0, 0.0, 0.0],
]


def test_joystick_steps_are_reached_through_singular_configurations() -> None:
    """Run B, Figures 4.7-4.9."""
    allocator = Allocator(VESSEL, ROTATING)
    before = allocator.step([0.0, 0.0, 0.0], DT)
    smallest = math.inf
    for tau in JOYSTICK:
        for _ in range(40):
            result = allocator.step(tau, DT)
            turned = np.abs(wrap_angles(result.azimuth - before.azimuth))
            assert np.degrees(turned).max() <= 12.04  # 0.21 rad (B.27) is 12.03 deg
            assert (np.abs(result.thrust - before.thrust) <= 0.2 * VESSEL.thrust_max + 1e-9).all()  # (B.25)
            B = np.vstack([np.cos(result.azimuth), np.sin(result.azimuth), np.zeros(4)])
            B[2] = VESSEL.lever_x * B[1] - VESSEL.lever_y * B[0]
            smallest = min(smallest, float(np.linalg.svd(B[:, 1:], compute_uv=False)[-1]))
            before = result
        # Eight seconds are half a turn (3 s) twice and the rise of thrust (1 s).
        np.testing.assert_allclose(result.tau_achieved, tau, atol=0.01)
    assert smallest < 0.05  # singular configurations were passed on the way


def test_half_way_into_each_phase_the_settings_can_change() -> None:
    random = np.random.default_rng(8)
    allocator = Allocator(VESSEL, FIXED)
    for _ in range(200):
        allocator.apply(random.choice(np.array([FIXED, ROTATING], dtype=object)))
        tau = random.normal(size=3) * [8.0, 6.0, 3.0]
        for _ in range(random.integers(1, 6)):
            assert allocator.step(tau, DT).status is Status.OPTIMAL


def test_auto_begins_from_what_the_demand_has_been() -> None:
    """The filter (6.3) goes on while the operator holds a mode: no switch to fixed and back on the way to auto."""
    for tau, mode in (([4.0, 0.0, 0.0], "rotating"), ([0.2, 0.0, 0.0], "fixed")):
        made = Allocator(VESSEL, AllocatorSettings.for_vessel(VESSEL, azimuth_mode="variable"))
        for _ in range(200):  # 40 s: eight time constants of 5 s
            assert made.step(tau, DT).azimuth_mode == "rotating"
        made.apply(AllocatorSettings.for_vessel(VESSEL, azimuth_mode="auto"))
        # The dwell time is long over, so that the first step decides.
        assert made.step(tau, DT).azimuth_mode == mode


@pytest.mark.parametrize("size", [1e15, 1.5e308])
def test_one_absurd_demand_does_not_hold_auto(size: float) -> None:
    made = Allocator(VESSEL, AllocatorSettings.for_vessel(VESSEL, azimuth_mode="auto"))
    made.step([size, -size, 0.0], DT)
    # The filter took ten times the vessel's thrust for one sample of 0.2 s and a time constant of 5 s; from 30 N it is
    # below 1.3 N after 16 s, and the dwell time is shorter.
    modes = [made.step([0.0, 0.0, 0.0], DT).azimuth_mode for _ in range(150)]
    assert modes[-1] == "fixed"
