"""Real-time singularity avoidance, step by step: [Ruth] (7.128), its lock, and the questions of 8.2."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.plan.limits import limit_table
from thrust_allocator.plan.phase import Limit
from thrust_allocator.settings import AllocatorSettings
from thrust_allocator.singularity import minimum_gain, scaled_configuration, scaling_of
from thrust_allocator.singularity.avoidance import Avoidance, AvoidanceReport
from thrust_allocator.singularity.settings import SingularitySettings

VESSEL = load_vessel("cybership3")
ENGINE = Engine(VESSEL)
SCALING = scaling_of(VESSEL)
DT = 0.2
METHODS = ("three_step", "required_gain", "crossing")
FIXED = VESSEL.fixed_direction
GOOD = np.radians([90.0, 90.0, 45.0, -45.0])
POOR = np.radians([90.0, 0.0, 0.0, 0.0])  # sway and yaw from the tunnel alone


def limits_for(**overrides: Any) -> FloatArray:
    table = limit_table(VESSEL, AllocatorSettings(azimuth_mode="rotating", **overrides))
    table[:, Limit.AZIMUTH_RATE] = np.minimum(table[:, Limit.AZIMUTH_RATE], 0.5)  # Run K
    return table


LIMITS = limits_for()


def run(limits: FloatArray, before: FloatArray, multiplier: FloatArray, tau: FloatArray) -> Answer:
    return ENGINE.run(limits, before, multiplier, ENGINE.weights.thrust, tau, DT)


def at(azimuth: FloatArray) -> FloatArray:
    table = np.zeros((4, 5))
    table[:, 1] = azimuth
    return table


def gain(azimuth: FloatArray) -> float:
    return minimum_gain(scaled_configuration(SCALING, azimuth)).gain


def make(method: str, **overrides: Any) -> Avoidance:
    return Avoidance(VESSEL, ENGINE, SingularitySettings(method=method, **overrides))


def aiming(free: Callable[[], FloatArray]) -> Any:
    """An engine whose first step points wherever the test says."""

    def run_to(limits: FloatArray, before: FloatArray, multiplier: FloatArray, tau: FloatArray) -> Answer:
        answer = run(limits, before, multiplier, tau)
        if limits[1, Limit.ROTATING]:
            answer.commands[:, 1] = free()
        return answer

    return run_to


def test_7_128_by_hand() -> None:
    avoidance = make("three_step", dwell_time=0.5)
    start = np.radians([90.0, 70.0, 60.0, -60.0])
    before = at(start)
    tau = np.array([1.0, 0.5, 0.0])
    # sigma(GOOD) is above 0.5 and must have been so for more than 0.5 s: at the third sample of 0.2 s.
    other = np.radians([90.0, 80.0, 60.0, -30.0])
    plan = [(GOOD, start, True), (GOOD, start, True), (GOOD, GOOD, False), (other, other, False)]
    # One poor sample, and the dwell time begins anew.
    plan += [(POOR, other, True), (GOOD, other, True), (GOOD, other, True), (GOOD, GOOD, False)]
    assert min(gain(start), gain(GOOD), gain(other)) > 0.5
    assert gain(POOR) < 0.1
    for alpha_a, expected, waiting in plan:
        target = alpha_a
        answer, report = avoidance.step(aiming(lambda t=target: t), LIMITS, before, tau, DT)
        turn = wrap_angles(expected - before[:, 1])
        moved = wrap_angles(answer.commands[:, 1] - before[:, 1])
        np.testing.assert_allclose(moved, np.clip(turn, -0.1, 0.1), atol=1e-12)
        assert report.minimum_gain_free == pytest.approx(gain(alpha_a), abs=1e-12)
        assert report.waiting == waiting
        before = answer.commands


def test_third_step_may_reverse() -> None:
    avoidance = make("three_step")
    before = at(np.radians([90.0, 90.0, 45.0, -45.0]))
    least = 0.0
    for _ in range(30):
        answer, _ = avoidance.step(aiming(lambda: POOR), LIMITS, before, np.array([-6.0, 0.0, 0.0]), DT)
        before = answer.commands
        least = min(least, before[2:, 0].min())
    np.testing.assert_allclose(before[:, 1], GOOD, atol=1e-12)
    assert least < -1.0
    np.testing.assert_allclose(answer.totals[:3], [-6.0, 0.0, 0.0], atol=1e-3)


def test_a_lock_is_told_and_released() -> None:
    """alpha_A stays poor, and the demand lies across what is kept."""
    tau = np.array([12.0, 0.0, 0.0])
    start = np.radians([90.0, 90.0, 80.0, -80.0])  # hardly any surge; 0.5 and more needs no cost
    assert gain(start) > 0.25
    found: dict[bool, AvoidanceReport] = {}
    for release in (False, True):
        avoidance = make("three_step", release=release, gain_limit=0.25)
        before = at(start)
        reports = []
        for _ in range(150):
            answer, report = avoidance.step(aiming(lambda: POOR), LIMITS, before, tau, DT)
            before = answer.commands
            reports.append(report)
        found[release] = reports[-1]
        locked = [r.locked for r in reports]
        # Not before lock_time, 6.3 s.
        assert not any(locked[: int(6.2 / DT)])
        assert any(locked)
        assert any(r.released for r in reports) == release
    assert found[False].locked
    assert not found[True].locked
    assert found[True].minimum_gain >= 0.25 * (1.0 - 1e-6)
    assert found[True].cost_kept < 0.5 * found[False].cost_kept


def test_insufficient_angles_at_the_start_are_left_at_once() -> None:
    for method in METHODS:
        avoidance = make(method)
        before = at(POOR)
        for k in range(60):
            answer, report = avoidance.step(run, LIMITS, before, np.array([3.0, 0.0, 0.0]), DT)
            if k == 0:
                assert np.abs(answer.commands[:, 1] - POOR).max() == pytest.approx(0.1)  # full rate
            before = answer.commands
        assert report.minimum_gain >= 0.5 * (1.0 - 1e-6)


demand = st.tuples(st.floats(-14.0, 14.0), st.floats(-10.0, 10.0), st.floats(-4.0, 4.0)).map(np.array)


@given(
    st.sampled_from(METHODS),
    st.lists(
        st.tuples(
            demand,
            st.tuples(*[st.booleans()] * 4),
            st.tuples(*[st.sampled_from((True, True, False))] * 4),
            st.sampled_from((1.0, 0.5, 0.0)),
        ),
        min_size=1,
        max_size=4,
    ),
)
@settings(max_examples=60, deadline=None)
def test_every_failure_stays_within_the_limits(method: str, phases: list[Any]) -> None:
    avoidance = make(method)
    before = at(FIXED)
    for tau, enabled, turning, scale in phases:
        limits = limits_for(
            thruster_enabled=enabled, azimuth_enabled=turning, thrust_limit_scale=(1.0, scale, 1.0, 1.0)
        )
        for _ in range(12):
            answer, report = avoidance.step(run, limits, before, tau, DT)
            assert not answer.complaint
            now = answer.commands
            assert np.isfinite(now).all()
            # Rounding, as everywhere: 1e-9 rad and N.
            turn = np.abs(wrap_angles(now[:, 1] - before[:, 1]))
            assert (turn <= limits[:, Limit.AZIMUTH_RATE] * DT + 1e-9).all()
            assert (turn[~(limits[:, Limit.MAY_ROTATE] != 0.0)] <= 1e-9).all()
            assert (np.abs(now[:, 0] - before[:, 0]) <= VESSEL.thrust_rate * DT + 1e-9).all()
            assert (now[:, 0] <= np.maximum(limits[:, Limit.THRUST_MAX], before[:, 0]) + 1e-9).all()
            assert (now[:, 0] >= np.minimum(limits[:, Limit.THRUST_MIN], before[:, 0]) - 1e-9).all()
            assert report.method in (method, "none")
            before = now


@given(st.lists(demand, min_size=1, max_size=3))
@settings(max_examples=25, deadline=None)
def test_required_gain_is_never_left(demands: list[FloatArray]) -> None:
    avoidance = make("required_gain")
    before = at(FIXED)
    assert gain(FIXED) > 0.5
    for tau in demands:
        for _ in range(40):
            answer, report = avoidance.step(run, LIMITS, before, tau, DT)
            before = answer.commands
            assert report.minimum_gain == pytest.approx(gain(before[:, 1]), abs=1e-12)
            # Along a way through grid points the gain is looked at every few degrees only.
            assert report.minimum_gain >= 0.5 - 3 * 1.5 * 0.022


@given(st.lists(demand, min_size=1, max_size=3))
@settings(max_examples=25, deadline=None)
def test_three_step_rests_only_where_the_gain_suffices(demands: list[FloatArray]) -> None:
    avoidance = make("three_step")
    before = at(FIXED)
    for tau in demands:
        for _ in range(40):
            answer, report = avoidance.step(run, LIMITS, before, tau, DT)
            turned = np.abs(wrap_angles(answer.commands[:, 1] - before[:, 1])).max()
            before = answer.commands
            assert report.minimum_gain >= 0.5 * (1.0 - 1e-6) or turned > 0.0


@given(demand)
@settings(max_examples=10, deadline=None)
def test_mirror_symmetry_of_three_step(tau: FloatArray) -> None:
    """A vessel whose port and starboard thrusters are equal, the demand mirrored: so are the commands."""
    limits = LIMITS.copy()
    for column in (Limit.THRUST_MIN, Limit.THRUST_MAX, Limit.THRUST_RATE, Limit.ZERO_THRUST, Limit.SPAN):
        limits[3, column] = limits[2, column]
    limits[0, Limit.THRUST_MIN] = -limits[0, Limit.THRUST_MAX]
    # The last two thrusters weigh almost the same, not quite: weights that are equal.
    weight = ENGINE.weights.thrust.copy()
    weight[3] = weight[2]

    def equal(table: FloatArray, before: FloatArray, multiplier: FloatArray, demand: FloatArray) -> Answer:
        return ENGINE.run(table, before, multiplier, weight, demand, DT)

    start = np.radians([90.0, 0.0, 50.0, -40.0])
    mirror, swap = np.array([1.0, -1.0, -1.0]), [0, 1, 3, 2]
    ends = []
    for sign in (np.ones(3), mirror):
        avoidance = make("three_step", release=False, gain_limit=0.3)
        azimuth = start if sign[1] > 0 else np.array([math.pi / 2, 0.0, 40.0 * math.pi / 180, -50.0 * math.pi / 180])
        before = at(azimuth)
        for _ in range(5):
            answer, _ = avoidance.step(equal, limits, before, tau * sign, DT)
            before = answer.commands
        ends.append(before)
    plain, mirrored = ends[0], ends[1][swap]
    # The tunnel keeps its direction: its thrust changes sign. Solver's accuracy.
    np.testing.assert_allclose(plain[1:, 0], mirrored[1:, 0], atol=1e-6)
    np.testing.assert_allclose(plain[0, 0], -mirrored[0, 0], atol=1e-6)
    used = plain[1:, 0] > 1e-3
    np.testing.assert_allclose(wrap_angles(plain[1:, 1] + mirrored[1:, 1])[used], 0.0, atol=1e-4)


def test_required_gain_rests_near_the_best_of_all() -> None:
    """Brute force over 15 deg: what comes out costs at most the switch ratio more, and a grid cell."""
    tau = np.array([-6.1, 3.1, 1.1])
    avoidance = make("required_gain")
    before = at(FIXED)
    for _ in range(300):
        answer, report = avoidance.step(run, LIMITS, before, tau, DT)
        before = answer.commands
    B = ENGINE.columns
    best = math.inf
    grid = np.radians(np.arange(0.0, 180.0, 15.0))
    Q, W = np.diag(1.0 / ENGINE.weights.slack), ENGINE.weights.thrust
    for a in grid:
        for b in grid:
            for c in grid:
                azimuth = np.array([math.pi / 2, a, b, c])
                if gain(azimuth) < 0.5:
                    continue
                columns = np.array([B[j] @ [math.cos(azimuth[j]), math.sin(azimuth[j])] for j in range(4)]).T
                best = min(best, float(tau @ np.linalg.solve(Q + columns / W @ columns.T, tau)))
    # Without limits of thrust: a lower bound of that grid's best.
    assert report.minimum_gain >= 0.5 * (1.0 - 1e-6)
    assert report.cost_kept <= best * 10.0**0.04


def _after(method: str, scale: float, **overrides: Any) -> list[AvoidanceReport]:
    """Rest at one demand, then another that is best answered elsewhere."""
    first, second = np.array([3.5, 4.6, -3.2]), np.array([-2.5, 1.3, -0.9])
    avoidance = make(method, **overrides)
    before = at(FIXED)
    reports = []
    for k in range(250):
        answer, report = avoidance.step(run, LIMITS, before, scale * (first if k < 100 else second), DT)
        before = answer.commands
        if k >= 100:
            reports.append(report)
    return reports


def test_crossing_goes_through_where_required_gain_goes_round() -> None:
    crossed = _after("crossing", 1.0)
    assert any(r.crossing for r in crossed)
    assert min(r.minimum_gain for r in crossed) < 0.5
    kept = _after("required_gain", 1.0)
    assert not any(r.crossing for r in kept)
    assert min(r.minimum_gain for r in kept) >= 0.5 - 3 * 1.5 * 0.022
    # Once across, it rests with sufficient gain, at no more than the other by the switch ratio.
    assert crossed[-1].minimum_gain >= 0.5 * (1.0 - 1e-6)
    assert crossed[-1].cost_kept <= kept[-1].cost_kept * 10.0**0.04


def test_crossing_waits_when_the_demand_is_large_and_goes_when_it_is_small() -> None:
    """With patience without end only the demand decides: with its margin it must be attainable all the way."""
    small = _after("crossing", 0.1, patience=1e6)
    large = _after("crossing", 1.0, patience=1e6)
    assert any(r.crossing for r in small)
    assert not any(r.crossing for r in large)
    assert sum(r.waiting for r in large) > 10
    # A margin that the way does not have keeps the small demand waiting as well.
    assert not any(r.crossing for r in _after("crossing", 0.1, patience=1e6, demand_margin=5.0))
    # What waiting has cost, and what crossing would, decide otherwise.
    paid = _after("crossing", 1.0)
    assert any(r.crossing for r in paid)
    assert not paid[0].crossing


def test_what_is_refused() -> None:
    plain = VESSEL.model_copy(update={"allocator": VESSEL.allocator.model_copy(update={"singularity": None})})
    with pytest.raises(InputError, match=r"singularity.gain_limit: expected a number here or allocator.singularity"):
        Avoidance(plain, ENGINE, SingularitySettings(method="crossing"))
    Avoidance(plain, ENGINE, SingularitySettings(method="crossing", gain_limit=0.4, dwell_time=0.0, lock_time=5.0))
    avoidance = make("three_step")
    with pytest.raises(InputError, match="gain_limit: expected a number above 0"):
        avoidance.apply(SingularitySettings(method="three_step", gain_limit=0.0))
    assert avoidance.settings.gain_limit is None
    with pytest.raises(InputError, match="dt"):
        avoidance.step(run, LIMITS, at(FIXED), np.zeros(3), 0.0)
