"""Failed thrusters, failed solvers, bad input: always an answer, and it has a name."""

from __future__ import annotations

import itertools
import math
import re
from typing import Any

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.propellers.sections import BollardData
from thrust_allocator import (
    AllocationProblem,
    Allocator,
    AllocatorSettings,
    Phase,
    Solution,
    Solver,
    Status,
    check_settings,
    judge,
)
from thrust_allocator.singularity.settings import SingularitySettings

VESSEL = load_vessel("cybership3")
DT = 0.2
TAU = [3.0, 1.0, 0.5]


class Broken(Solver):
    """Gives what it is told to, whatever the problem."""

    def __init__(self, z: float | None) -> None:
        self.z = z

    @property
    def name(self) -> str:
        return "broken"

    def solve(self, problem: AllocationProblem) -> Solution | None:
        if self.z is None:
            return None
        z, multipliers = np.full(problem.variables, self.z), np.zeros(len(problem.b_upper))
        return Solution(z, multipliers, 7, "all is well", judge(problem, z, multipliers))


def allocator(mode: str = "rotating", steps: int = 10, **settings: Any) -> Allocator:
    made = Allocator(VESSEL, AllocatorSettings.for_vessel(VESSEL, azimuth_mode=mode, **settings))
    for _ in range(steps):
        made.step(TAU, DT)
    return made


def breaking(z: float | None, mode: str, steps: int = 10) -> Allocator:
    made = allocator(mode, steps)
    made._engine._solver = Broken(z)
    return made


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
@pytest.mark.parametrize(
    ("z", "message"),
    [
        (None, "broken gave no answer"),
        (math.nan, "broken failed (all is well): violation"),
        (100.0, "broken failed (all is well): violation"),  # beyond every limit, whatever the solver says
        (0.0, "stationarity"),  # not the optimum
    ],
)
def test_a_wrong_answer_is_not_used(mode: str, z: float | None, message: str) -> None:
    failing = breaking(z, mode)
    before = allocator(mode).step(TAU, DT)
    failing.reset(before.thrust, before.azimuth)
    result = failing.step(TAU, DT)
    assert result.status is Status.HOLD
    assert message in result.message
    np.testing.assert_array_equal(result.thrust, before.thrust)
    np.testing.assert_array_equal(result.azimuth, before.azimuth)
    np.testing.assert_allclose(result.tau_achieved + result.slack, TAU, atol=1e-12)
    # Problem and what the solver made of it travel with the result and stay as they were.
    assert result.problem is not None
    kept = result.problem.f.copy()
    failing.step([9.0, 9.0, 9.0], DT)
    np.testing.assert_array_equal(result.problem.f, kept)
    assert (result.solution is None) == (z is None)


def test_hold_still_obeys_new_limits_and_turns_to_fixed_directions() -> None:
    failing = breaking(None, "rotating", 30)
    before = failing._before[:, 0].copy(), failing._before[:, 1].copy()
    limited = AllocatorSettings(
        azimuth_mode="fixed", thrust_limit_scale=(1.0, 1.0, 0.01, 1.0), thruster_enabled=(True, True, True, False)
    )
    solver = failing._engine._solver
    failing.apply(limited)
    failing._engine._solver = solver
    result = failing.step(TAU, DT)
    assert result.status is Status.HOLD
    step = VESSEL.thrust_rate * DT
    assert result.thrust[1] == before[0][1]
    assert result.thrust[2] == pytest.approx(max(0.135, before[0][2] - 0.9 * step[2]))
    assert result.thrust[3] == pytest.approx(max(0.0, before[0][3] - step[3]))
    assert result.phase == (Phase.FIXED, Phase.TURNING, Phase.TURNING, Phase.LOST)
    assert result.azimuth[1] != before[1][1]


def test_a_good_solver_recovers_after_hold() -> None:
    failing = breaking(None, "rotating")
    assert failing.step(TAU, DT).status is Status.HOLD
    failing.apply(AllocatorSettings(azimuth_mode="rotating"))  # puts the solver back
    result = failing.step(TAU, DT)
    assert result.status is Status.OPTIMAL
    assert result.message == ""
    assert result.problem is None


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_demand_that_is_not_finite_leaves_the_last_good_one(bad: float, axis: int) -> None:
    good, faulty = allocator(), allocator()
    tau = [5.0, -2.0, 0.3]
    good.step(tau, DT)
    faulty.step(tau, DT)
    spoiled = [1.0, 1.0, 1.0]
    spoiled[axis] = bad
    for _ in range(3):
        expected, found = good.step(tau, DT), faulty.step(spoiled, DT)
        assert found.status is Status.DEMAND_NOT_FINITE
        assert "tau_desired: expected finite numbers, found [" in found.message
        np.testing.assert_array_equal(found.tau_desired, tau)
        np.testing.assert_array_equal(found.thrust, expected.thrust)
        np.testing.assert_array_equal(found.azimuth, expected.azimuth)
    assert faulty.step(tau, DT).status is Status.OPTIMAL


def test_before_the_first_good_demand_zero_stands() -> None:
    result = Allocator(VESSEL).step([math.nan, 1.0, 1.0], DT)
    assert result.status is Status.DEMAND_NOT_FINITE
    np.testing.assert_array_equal(result.tau_desired, np.zeros(3))
    np.testing.assert_array_equal(result.thrust, np.zeros(4))


def test_a_bad_demand_and_a_bad_solver_are_both_told() -> None:
    result = breaking(None, "fixed").step([math.nan, 0.0, 0.0], DT)
    assert result.status is Status.HOLD
    assert result.message.startswith("tau_desired: expected finite numbers")
    assert result.message.endswith("broken gave no answer")


@pytest.mark.parametrize(
    ("tau", "dt", "message"),
    [
        ([1.0, 2.0], DT, "tau_desired: expected shape (3,), found (2,)"),
        ([1.0, 2.0, 3.0, 4.0], DT, "tau_desired: expected shape (3,), found (4,)"),
        ([[1.0, 2.0, 3.0]], DT, "tau_desired: expected shape (3,), found (1, 3)"),
        (1.0, DT, "tau_desired: expected shape (3,), found ()"),
        ("north", DT, "tau_desired: expected 3 numbers, found 'north'"),
        (TAU, 0.0, "dt: expected a number above 0, found 0.0"),
        (TAU, -0.2, "dt: expected a number above 0, found -0.2"),
        (TAU, math.nan, "dt: expected a finite number, found nan"),
    ],
)
def test_refused_input_changes_nothing(tau: Any, dt: float, message: str) -> None:
    disturbed, calm = allocator(), allocator()
    with pytest.raises(InputError, match=re.escape(message)):
        disturbed.step(tau, dt)
    expected, found = calm.step(TAU, DT), disturbed.step(TAU, DT)
    np.testing.assert_array_equal(found.thrust, expected.thrust)
    np.testing.assert_array_equal(found.azimuth, expected.azimuth)


@pytest.mark.parametrize("field", ["thruster_enabled", "azimuth_enabled", "thrust_limit_scale", "fixed_direction"])
def test_settings_of_the_wrong_length_are_refused_and_the_old_ones_stay(field: str) -> None:
    made = allocator()
    old = made.settings
    value: tuple[float | bool, ...] = (True,) * 3 if field.endswith("enabled") else (1.0,) * 3
    message = (
        f"{field}: expected 4 elements, one a thruster "
        "(tunnel_bow, azimuth_bow, azimuth_port, azimuth_starboard), found 3"
    )
    with pytest.raises(InputError, match=re.escape(message)):
        made.apply(AllocatorSettings(**{field: value}))
    assert made.settings is old
    with pytest.raises(InputError, match=re.escape(message)):
        Allocator(VESSEL, AllocatorSettings(**{field: value}))


def test_settings_out_of_range_are_refused() -> None:
    for bad in ({"thrust_limit_scale": (1.1,) * 4}, {"thrust_limit_scale": (-0.1,) * 4}, {"azimuth_mode": "automatic"}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            AllocatorSettings(**bad)


@pytest.mark.parametrize(
    ("thrust", "azimuth", "message"),
    [
        ([0.0] * 3, None, "thrust: expected shape (4,), found (3,)"),
        (None, [0.0, math.nan, 0.0, 0.0], "azimuth: expected finite numbers"),
    ],
)
def test_a_bad_operating_point_is_refused(thrust: Any, azimuth: Any, message: str) -> None:
    made = allocator()
    with pytest.raises(InputError, match=re.escape(message)):
        made.reset(thrust, azimuth)
    np.testing.assert_array_equal(made.step(TAU, DT).thrust, allocator().step(TAU, DT).thrust)


@pytest.mark.parametrize("enabled", list(itertools.product([True, False], repeat=4)))
def test_every_combination_of_failures_has_an_answer(enabled: tuple[bool, ...]) -> None:
    """2^4 thrusters lost or not, times 2^3 azimuth drives lost or not, in both modes, failing while at work."""
    for turning in itertools.product([True, False], repeat=3):
        for mode in ("fixed", "rotating"):
            made = allocator(mode, 6)
            made.apply(AllocatorSettings(azimuth_mode=mode, thruster_enabled=enabled, azimuth_enabled=(True, *turning)))
            before = made._before[:, 1]
            for _ in range(8):
                result = made.step([-8.0, 4.0, 2.0], DT)
                assert result.status is (Status.OPTIMAL if any(enabled) else Status.NO_THRUSTER), result.message
            for j, works in enumerate(enabled):
                if not works:  # 8 steps of a fifth of the maximum are enough from anywhere
                    assert result.thrust[j] == 0.0
                    assert result.phase[j] is Phase.LOST
                if j and not turning[j - 1]:
                    assert result.azimuth[j] == before[j]


def test_all_thrusters_lost() -> None:
    made = allocator("rotating", 0)
    for _ in range(20):
        made.step([20.0, 0.0, 0.0], DT)
    made.apply(AllocatorSettings(azimuth_mode="rotating", thruster_enabled=(False,) * 4))
    first = made.step(TAU, DT)
    assert first.status is Status.NO_THRUSTER
    assert first.message == "every thruster is lost"
    assert first.thrust.max() > 0.0  # the command is still on its way down
    np.testing.assert_array_equal(first.tau_achieved, np.zeros(3))
    np.testing.assert_array_equal(first.slack, TAU)
    assert first.demanded_power == 0.0
    for _ in range(6):
        last = made.step(TAU, DT)
    np.testing.assert_array_equal(last.thrust, np.zeros(4))
    made.apply(AllocatorSettings(azimuth_mode="rotating"))
    for _ in range(30):
        back = made.step(TAU, DT)
    np.testing.assert_allclose(back.tau_achieved, TAU, atol=1e-3)


def test_a_lost_thruster_ramps_down_contributes_nothing_and_feathers_back_in() -> None:
    made = allocator("fixed", 20)
    before = made.step([6.0, 0.0, 0.0], DT)
    made.apply(AllocatorSettings(thruster_enabled=(True, True, False, True)))
    thrust = before.thrust[2]
    while thrust != 0.0:
        result = made.step([6.0, 0.0, 0.0], DT)
        assert result.thrust[2] == pytest.approx(max(thrust - 13.5 * DT, 0.0))
        thrust = result.thrust[2]
        others = [0, 1, 3]
        surge = float(np.sum(result.thrust[others] * np.cos(result.azimuth[others])))
        assert result.tau_achieved[0] == pytest.approx(surge, abs=1e-12)
        power = VESSEL.propellers.power(result.thrust)
        assert result.demanded_power == pytest.approx(power[others].sum())
    made.apply(AllocatorSettings())
    assert 0.0 < made.step([6.0, 0.0, 0.0], DT).thrust[2] <= 13.5 * DT


def test_a_lowered_limit_is_reached_at_c1_of_the_rate() -> None:
    made = allocator("fixed", 0)
    for _ in range(20):
        before = made.step([18.0, 0.0, 0.0], DT)
    assert before.thrust[2] > 12.0
    made.apply(AllocatorSettings(thrust_limit_scale=(1.0, 1.0, 0.2, 1.0)))
    thrust = before.thrust[2]
    while thrust > 0.2 * 13.5:
        result = made.step([18.0, 0.0, 0.0], DT)
        assert result.thrust[2] == pytest.approx(max(thrust - 0.9 * 13.5 * DT, 0.2 * 13.5), abs=1e-9)
        thrust = result.thrust[2]


def test_power_is_that_of_3_11() -> None:
    result = allocator("fixed", 20).step(TAU, DT)
    total = 0.0
    for thruster, thrust in zip(VESSEL.thrusters, result.thrust, strict=True):
        p = thruster.propeller
        assert isinstance(p, BollardData)
        factor = 2.0 * math.pi * p.torque_coefficient / (math.sqrt(1000.0) * p.diameter * p.thrust_coefficient**1.5)
        total += factor * abs(thrust) ** 1.5
    assert result.demanded_power == pytest.approx(total, rel=1e-12)


def test_cost_is_that_of_4_10() -> None:
    result = allocator("rotating", 2).step([9.0, 9.0, 4.0], DT)
    weighted = 1000.0 * np.array([1.0, 1.0, 10.0]) * result.slack
    thrust = np.array([14.0, 1.2, 0.85, 0.87]) * result.thrust
    assert result.cost == pytest.approx(weighted @ weighted + thrust @ thrust, rel=1e-12)


def test_a_long_gap_opens_no_longer_window() -> None:
    """The commands have been standing since; thrusters cannot have begun what was not asked for."""
    made = Allocator(VESSEL, AllocatorSettings(longest_step=1.5))
    result = made.step([50.0, 0.0, 0.0], 60.0)
    assert result.thrust[2] == pytest.approx(13.5 * 1.5 * 0.2)


def test_one_step_turns_no_more_than_a_convex_window_allows() -> None:
    """With steps of 2 s the rate alone would allow 2.1 rad, and a cone of 240 deg is not convex."""
    made = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating", longest_step=10.0))
    for _ in range(6):
        before = made._before[:, 1]
        result = made.step([-4.0, 0.0, 0.0], 2.0)
        assert result.status is Status.OPTIMAL
        assert np.abs(wrap_angles(result.azimuth - before)).max() <= math.pi / 3 + 1e-9
    np.testing.assert_allclose(result.tau_achieved, [-4.0, 0.0, 0.0], atol=1e-3)


def test_saturation_is_reported() -> None:
    made = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"))
    first = made.step([60.0, 0.0, 0.0], DT)
    assert first.thrust_saturated[2:] == (True, True)  # rate
    assert first.azimuth_saturated[2:] == (True, True)  # turning from 45 and -45 deg to ahead
    for _ in range(40):
        last = made.step([60.0, 0.0, 0.0], DT)
    assert last.thrust[2:] == pytest.approx([13.5, 13.0], abs=1e-3)
    assert last.thrust_saturated[2:] == (True, True)  # magnitude
    assert last.azimuth_saturated[2:] == (False, False)
    idle = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating")).step([0.0, 0.0, 0.0], DT)
    assert idle.thrust_saturated == (False,) * 4
    assert idle.azimuth_saturated == (False,) * 4


@pytest.mark.parametrize("method", ["required_gain", "crossing"])
def test_a_search_over_too_many_angles_is_refused_before_it_is_accepted(method: str) -> None:
    document = VESSEL.model_dump(mode="json")
    for name in ("azimuth_mid_port", "azimuth_mid_starboard"):
        document["thrusters"].append(document["thrusters"][1] | {"name": name})
    document["allocator"]["thrust_weight"] += [1.2, 1.2]
    document["drivers"]["ventilation"]["speed_min"] += [5.0, 5.0]
    larger = Vessel.model_validate(document)
    settings = AllocatorSettings.for_vessel(larger, singularity=SingularitySettings(method=method))
    with pytest.raises(InputError, match="expected three_step with more than 4 azimuth thrusters"):
        check_settings(settings, larger)
    check_settings(AllocatorSettings.for_vessel(larger, singularity=SingularitySettings(method="three_step")), larger)
