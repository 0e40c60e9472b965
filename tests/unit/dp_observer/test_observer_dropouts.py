"""Lost, late and wild measurements."""

from __future__ import annotations

import numpy as np
import pytest

from dp_observer import Observer, ObserverEstimate, ObserverInputs, ObserverSettings, ObserverStatus
from marine_model import load_vessel
from marine_model.guards import FloatArray

VESSEL = load_vessel("cybership3")
SAMPLE = VESSEL.measurement.sample_time
LENGTH = VESSEL.hull.length
NO_FORCE = np.zeros(3)


def place(t: float) -> FloatArray:
    """A vessel that drifts north at 0.05 m/s, heading one radian."""
    return np.array([0.05 * t, 2.0, 1.0])


def steady(settings: ObserverSettings | None = None, samples: int = 1500) -> tuple[Observer, float]:
    """An observer that has watched the drifting vessel long enough to know velocity and bias; the time."""
    observer = Observer(VESSEL, settings or ObserverSettings())
    for k in range(samples):
        observer.step(ObserverInputs(place(k * SAMPLE), NO_FORCE), SAMPLE)
    return observer, (samples - 1) * SAMPLE


def fix(observer: Observer, position: FloatArray, dt: float = SAMPLE) -> ObserverEstimate:
    return observer.step(ObserverInputs(position, NO_FORCE), dt)


def none(observer: Observer, dt: float = SAMPLE) -> ObserverEstimate:
    return observer.step(ObserverInputs(None, NO_FORCE), dt)


def test_nothing_is_known_before_the_first_fix() -> None:
    observer = Observer(VESSEL, ObserverSettings())
    estimate = none(observer)
    assert estimate.status is ObserverStatus.UNINITIALISED
    assert not estimate.valid
    estimate = none(observer)
    assert estimate.time_since_measurement == pytest.approx(2 * SAMPLE)
    assert not estimate.position.any()
    assert not estimate.velocity.any()


def test_first_fix_initialises_anywhere() -> None:
    observer = Observer(VESSEL, ObserverSettings())
    none(observer)
    estimate = fix(observer, np.array([1e4, -2e4, 7.0]))
    assert estimate.status is ObserverStatus.INITIALISED
    assert estimate.valid
    np.testing.assert_array_equal(estimate.position, [1e4, -2e4, 7.0 - 2 * np.pi])
    np.testing.assert_array_equal(estimate.velocity, 0.0)
    assert estimate.time_since_measurement == 0.0
    estimate = fix(observer, np.array([1e4, -2e4, 7.0]))
    assert estimate.status is ObserverStatus.NOMINAL
    # Coordinates of 2e4 m have a rounding of 4e-12 m, times gains of tens a second.
    np.testing.assert_allclose(estimate.velocity, 0.0, atol=1e-9)


def test_dead_reckoning_carries_the_vessel_on() -> None:
    observer, t = steady()
    for k in range(1, 26):
        estimate = none(observer)
        assert estimate.status is ObserverStatus.DEAD_RECKONING
        assert estimate.valid
        assert estimate.time_since_measurement == pytest.approx(k * SAMPLE)
        np.testing.assert_array_equal(estimate.innovation, 0.0)
    # What was not known to the last digit after 300 s, exp(-0.052 * 300) = 2e-7, times 5 s squared.
    np.testing.assert_allclose(estimate.position, place(t + 5.0), atol=1e-4)


def test_estimate_becomes_invalid_after_the_limit_and_recovers_with_the_next_fix() -> None:
    observer, t = steady(ObserverSettings(dead_reckoning_limit=2.0))
    states = [none(observer) for _ in range(12)]
    assert [e.valid for e in states] == [True] * 10 + [False] * 2
    assert {e.status for e in states[:10]} == {ObserverStatus.DEAD_RECKONING}
    assert {e.status for e in states[10:]} == {ObserverStatus.INVALID}
    estimate = fix(observer, place(t + 13 * SAMPLE))
    assert estimate.valid
    assert estimate.status is ObserverStatus.NOMINAL
    assert estimate.time_since_measurement == 0.0


def test_a_fix_far_off_after_a_loss_restarts_the_position() -> None:
    observer, _ = steady(ObserverSettings(dead_reckoning_limit=2.0))
    before = [none(observer) for _ in range(12)][-1]
    elsewhere = np.array([40.0, -20.0, -2.0])
    estimate = fix(observer, elsewhere)
    assert estimate.valid
    assert estimate.status is ObserverStatus.REINITIALISED
    np.testing.assert_array_equal(estimate.position, elsewhere)
    np.testing.assert_array_equal(estimate.wave_frequency_position, 0.0)
    # Velocity and bias are those of the model's last word; a jump of the position says nothing about them.
    np.testing.assert_allclose(estimate.bias, before.bias, rtol=1e-6)
    assert abs(estimate.innovation[0] - (40.0 - before.position[0])) < 0.1
    assert fix(observer, elsewhere).status is ObserverStatus.NOMINAL


def test_a_late_fix_is_predicted_for_and_used() -> None:
    """One step over the gap ends where single steps without a fix and then the fix end."""
    one, t = steady()
    other = one.fork()
    for _ in range(3):
        none(one)
    a = fix(one, place(t + 4 * SAMPLE) + 0.02)
    b = fix(other, place(t + 4 * SAMPLE) + 0.02, 4 * SAMPLE)
    for estimate in (a, b):
        assert estimate.status is ObserverStatus.NOMINAL
        assert estimate.valid
    for name in ("position", "velocity", "bias", "innovation"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-12, atol=1e-13)


def test_a_late_fix_counts_less_towards_velocity() -> None:
    """A metre that built up over n samples says 1/n of what it would say in one."""
    on_time, t = steady()
    late = on_time.fork()
    undisturbed = on_time.fork()
    quiet = fix(undisturbed, place(t + SAMPLE)).velocity
    push = np.array([0.05, 0.0, 0.0])
    on_time_velocity = fix(on_time, place(t + SAMPLE) + push).velocity - quiet
    late_velocity = fix(late, place(t + 5 * SAMPLE) + push, 5 * SAMPLE).velocity - quiet
    assert np.linalg.norm(late_velocity) < 0.5 * np.linalg.norm(on_time_velocity)


def test_a_gap_of_any_length_is_survived() -> None:
    observer, _ = steady()
    estimate = fix(observer, np.array([7.0, 8.0, 0.5]), 1e6)
    assert estimate.valid
    assert estimate.status is ObserverStatus.REINITIALISED
    observer, _ = steady()
    estimate = none(observer, 1e6)
    assert not estimate.valid
    assert estimate.status is ObserverStatus.INVALID
    assert np.isfinite(estimate.position).all()
    assert estimate.time_since_measurement == pytest.approx(1e6)


@pytest.mark.parametrize(
    "jump",
    [[0.3 * LENGTH, 0.0, 0.0], [0.0, -10.0, 0.0], [0.2 * LENGTH, 0.2 * LENGTH, 0.0], [0.0, 0.0, 0.5]],
)
def test_an_outlier_is_refused(jump: list[float]) -> None:
    observer, t = steady()
    twin = observer.fork()
    estimate = fix(observer, place(t + SAMPLE) + jump)
    assert estimate.status is ObserverStatus.OUTLIER_REFUSED
    assert estimate.valid
    np.testing.assert_allclose(estimate.innovation, jump, atol=1e-6)
    # Nothing of it got in: the estimate is that of a sample without a fix.
    without = none(twin)
    for name in ("position", "velocity", "bias", "wave_frequency_position"):
        np.testing.assert_array_equal(getattr(estimate, name), getattr(without, name))
    assert estimate.time_since_measurement == without.time_since_measurement
    assert fix(observer, place(t + 2 * SAMPLE)).status is ObserverStatus.NOMINAL


def test_an_innovation_at_the_limit_is_used() -> None:
    observer, t = steady()
    estimate = fix(observer, place(t + SAMPLE) + np.array([0.24 * LENGTH, 0.0, 0.34]))
    assert estimate.status is ObserverStatus.NOMINAL


def test_a_jump_that_stays_is_believed() -> None:
    observer, t = steady(ObserverSettings(reacceptance_count=3))
    shift = np.array([2.0, 0.0, 0.0])
    found = [fix(observer, place(t + k * SAMPLE) + shift) for k in range(1, 6)]
    assert [e.status for e in found] == [
        *[ObserverStatus.OUTLIER_REFUSED] * 3,
        ObserverStatus.REINITIALISED,
        ObserverStatus.NOMINAL,
    ]
    np.testing.assert_array_equal(found[3].position, place(t + 4 * SAMPLE) + shift)
    np.testing.assert_allclose(found[4].velocity, found[0].velocity, atol=1e-3)


def test_wild_fixes_that_disagree_are_never_believed() -> None:
    observer, _ = steady(ObserverSettings(reacceptance_count=3, dead_reckoning_limit=60.0))
    random = np.random.default_rng(2)
    for k in range(1, 60):
        wild = np.array([10.0 * (1 + k % 7), 10.0 * random.uniform(1, 5) * (-1) ** k, 1.0])
        assert fix(observer, wild).status is ObserverStatus.OUTLIER_REFUSED


def test_a_good_fix_between_outliers_starts_the_count_anew() -> None:
    observer, t = steady(ObserverSettings(reacceptance_count=2))
    shift = np.array([2.0, 0.0, 0.0])
    pattern = [True, True, False, True, True, False]
    for k, off in enumerate(pattern, start=1):
        status = fix(observer, place(t + k * SAMPLE) + (shift if off else 0.0)).status
        assert status is (ObserverStatus.OUTLIER_REFUSED if off else ObserverStatus.NOMINAL)


def test_refused_fixes_do_not_keep_the_estimate_valid() -> None:
    observer, t = steady(ObserverSettings(dead_reckoning_limit=1.0, reacceptance_count=1000))
    statuses = [fix(observer, place(t) + np.array([5.0, 0.0, 0.0])).status for _ in range(6)]
    assert statuses[:5] == [ObserverStatus.OUTLIER_REFUSED] * 5
    assert statuses[5] is ObserverStatus.INVALID
    # Lost: now any fix will do.
    assert fix(observer, place(t) + np.array([5.0, 0.0, 0.0])).status is ObserverStatus.REINITIALISED


def test_new_settings_hold_from_the_next_step() -> None:
    observer, t = steady()
    jump = np.array([1.0, 0.0, 0.0])
    assert fix(observer, place(t + SAMPLE) + jump).status is ObserverStatus.OUTLIER_REFUSED
    observer.apply(ObserverSettings(innovation_limit=1.0))
    assert observer.settings.innovation_limit == 1.0
    assert fix(observer, place(t + 2 * SAMPLE) + jump).status is ObserverStatus.NOMINAL


def test_a_limit_of_zero_calls_every_lost_fix_invalid_and_still_gates() -> None:
    observer, t = steady(ObserverSettings(dead_reckoning_limit=0.0))
    assert fix(observer, place(t + SAMPLE)).valid
    assert fix(observer, place(t + 2 * SAMPLE) + 10.0).status is ObserverStatus.INVALID


def test_a_fork_goes_its_own_way() -> None:
    observer, t = steady()
    twin = observer.fork()
    for _ in range(30):
        none(twin)
    other, _ = steady()
    a, b = fix(observer, place(t + SAMPLE)), fix(other, place(t + SAMPLE))
    for name in ("position", "velocity", "bias", "wave_frequency_position", "innovation"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert a.status is ObserverStatus.NOMINAL
