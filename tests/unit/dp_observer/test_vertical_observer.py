"""Depth, roll and pitch: poles, bias, lost and refused fixes, each against a reckoning of its own."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from dp_observer import Observer, ObserverEstimate, ObserverInputs, ObserverSettings, ObserverStatus
from dp_observer.axis_models import AxisModels, corrected, steady_covariance
from dp_observer.estimate import VerticalEstimate
from dp_observer.vertical import VerticalObserver
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.vertical import VerticalObserverGains

SAMPLE = 0.2
SETTINGS = ObserverSettings()
# A neutral axis, one that the weight rights, and a heavily damped one; all slower than their bandwidth.
GAINS = VerticalObserverGains(
    mass=(300.0, 20.0, 40.0), damping=(30.0, 2.0, 40.0), stiffness=(0.0, 10.0, 8.0), bandwidth=(1.0, 1.5, 2.0)
)
# Righted so strongly that it is faster than its bandwidth.
STIFF = VerticalObserverGains(
    mass=(300.0, 20.0, 40.0), damping=(3.0, 1.0, 1.0), stiffness=(0.0, 400.0, 400.0), bandwidth=(1.0, 1.0, 1.0)
)
VESSELS = ("mmt300", "ukwial", "ukwial_azimuth")
STILL = np.zeros(3)


def axis_system(gains: VerticalObserverGains, axis: int) -> FloatArray:
    """Return A of (x, v, b) with b a force over mass."""
    m, d, k = gains.mass[axis], gains.damping[axis], gains.stiffness[axis]
    return np.array([[0.0, 1.0, 0.0], [-k / m, -d / m, 1.0], [0.0, 0.0, 0.0]])


class Plant:
    """Three axes that move as the model says, under forces that the observer is told of and others."""

    def __init__(self, gains: VerticalObserverGains, unknown: FloatArray, dt: float = SAMPLE) -> None:
        self.mass = np.array(gains.mass)
        self.unknown = unknown
        self.state = np.zeros((3, 3))
        self._moves = [expm(axis_system(gains, axis) * dt) for axis in range(3)]

    def step(self, tau: FloatArray) -> FloatArray:
        """Return depth, roll, pitch a sample later."""
        self.state[:, 2] = (self.unknown + tau) / self.mass
        self.state = np.array([move @ state for move, state in zip(self._moves, self.state, strict=True)])
        return self.state[:, 0].copy()


def observer(gains: VerticalObserverGains = GAINS) -> VerticalObserver:
    return VerticalObserver(gains, 2.0, SAMPLE)


def settled(gains: VerticalObserverGains = GAINS, samples: int = 300) -> tuple[VerticalObserver, Plant]:
    """Return an observer that has found the unknown force, and its plant."""
    plant, found = Plant(gains, np.array([-12.0, 0.3, -0.2])), observer(gains)
    for _ in range(samples):
        found.step(plant.step(STILL), STILL, SAMPLE, SETTINGS)
    return found, plant


def error(estimate: VerticalEstimate, plant: Plant) -> float:
    """Return how far the estimate is from the truth, as a share of what there is to estimate."""
    bias = np.abs(estimate.bias - plant.unknown) / np.abs(plant.unknown)
    return float(max(bias.max(), np.abs(estimate.position - plant.state[:, 0]).max()))


# Poles ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_with_fixes_that_come_fast_all_three_poles_are_at_the_bandwidth(axis: int) -> None:
    short = 1e-4  # s
    models = AxisModels(GAINS)
    step = models.over(short)
    covariance = steady_covariance(step, 1.0 / short)
    before = step.transition @ covariance @ step.transition.transpose(0, 2, 1) + step.noise
    gain = corrected(before, 1.0 / short)[0][axis]
    keep = np.eye(3)
    keep[:, 0] -= gain
    error_matrix = (keep @ step.transition[axis] - np.eye(3)) / short
    w = GAINS.bandwidth[axis]
    # The poles of a triple differ by the cube root of any error; the polynomial they make does not. It is that of the
    # continuous filter to the first order in w times the step, 2e-4.
    np.testing.assert_allclose(np.poly(error_matrix), [1.0, 3.0 * w, 3.0 * w**2, w**3], rtol=1e-3)


@pytest.mark.parametrize("gains", [GAINS, STIFF])
def test_steady_covariance_solves_the_riccati_equation(gains: VerticalObserverGains) -> None:
    step = AxisModels(gains).over(SAMPLE)
    found = steady_covariance(step, 1.0 / SAMPLE)
    for axis in range(3):
        fix = np.array([[1.0], [0.0], [0.0]])
        before = solve_discrete_are(step.transition[axis].T, fix, step.noise[axis], np.array([[1.0 / SAMPLE]]))
        seen = before @ fix
        after = before - seen @ seen.T / (before[0, 0] + 1.0 / SAMPLE)
        # Scipy's own residual in these is 1e-12 of the largest element.
        np.testing.assert_allclose(found[axis], after, rtol=1e-9, atol=1e-10 * np.abs(after).max())


def test_axes_are_carried_exactly() -> None:
    models = AxisModels(GAINS)
    one, many = models.over(1.3), models.over(0.013)
    for axis in range(3):
        np.testing.assert_allclose(one.transition[axis], expm(axis_system(GAINS, axis) * 1.3), rtol=1e-12, atol=1e-14)
    noise, force = np.zeros((3, 3, 3)), np.zeros((3, 3))
    for _ in range(100):
        noise = many.transition @ noise @ many.transition.transpose(0, 2, 1) + many.noise
        force = np.einsum("aij,aj->ai", many.transition, force) + many.force
    # Whatever the steps, the same to rounding: a hundred sums.
    np.testing.assert_allclose(noise, one.noise, rtol=1e-11)
    np.testing.assert_allclose(force, one.force, rtol=1e-11, atol=1e-13)
    # Over a short time, noise of density q adds q dt.
    w, damping, stiffness = GAINS.bandwidth[1], GAINS.damping[1] / GAINS.mass[1], GAINS.stiffness[1] / GAINS.mass[1]
    place = 3.0 * w**2 + 2.0 * stiffness - damping**2
    rate = 3.0 * w**4 - stiffness**2 - place * damping**2
    short = AxisModels(GAINS).over(1e-6)
    np.testing.assert_allclose(np.diagonal(short.noise[1]) / 1e-6, [place, rate, w**6], rtol=1e-5)


# What is estimated ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gains", [GAINS, STIFF])
def test_a_force_that_the_model_does_not_know_becomes_the_bias(gains: VerticalObserverGains) -> None:
    found, plant = settled(gains, 2000)
    estimate = found.step(plant.step(STILL), STILL, SAMPLE, SETTINGS)
    # The slowest pole of STIFF, its bias, is near w^3 m / k = 0.05 1/s: 400 s are exp(-20).
    assert error(estimate, plant) < 1e-6
    np.testing.assert_allclose(estimate.velocity, plant.state[:, 1], atol=1e-7)


def test_error_shrinks_as_its_poles_say() -> None:
    dt = 0.01
    plant, found = Plant(GAINS, np.array([-12.0, 0.3, -0.2]), dt), VerticalObserver(GAINS, 2.0, dt)
    biases = [found.step(plant.step(STILL), STILL, dt, SETTINGS).bias - plant.unknown for _ in range(1000)]
    # What three poles at w leave of a step in the bias. The first order of w dt = 0.02 is what sampling adds.
    times = dt * np.arange(1000)[:, None] * np.array(GAINS.bandwidth)
    left = np.array(biases) / -plant.unknown
    np.testing.assert_allclose(left, (1.0 + times + times**2 / 2.0) * np.exp(-times), atol=0.01)


def test_known_forces_are_felt_at_once() -> None:
    found, plant = settled()
    tau = np.array([50.0, 1.0, -2.0])
    for _ in range(10):
        estimate = found.step(None, tau, SAMPLE, SETTINGS)
        plant.step(tau)
    assert estimate.status is ObserverStatus.DEAD_RECKONING
    # What the bias has not found yet after 60 s, some exp(-54) of it, and rounding.
    np.testing.assert_allclose(estimate.position, plant.state[:, 0], atol=1e-9)
    np.testing.assert_allclose(estimate.velocity, plant.state[:, 1], atol=1e-9)


def test_angles_go_the_shorter_way() -> None:
    found = observer()
    found.step(np.array([1.0, np.pi - 0.02, -np.pi + 0.02]), None, SAMPLE, SETTINGS)
    estimate = found.step(np.array([1.0, -np.pi + 0.02, np.pi - 0.02]), None, SAMPLE, SETTINGS)
    assert estimate.status is ObserverStatus.NOMINAL
    # A restoring moment of half a turn moves the prediction by 0.04 rad of the 0.04 rad between the fixes.
    np.testing.assert_allclose(np.abs(estimate.innovation[1:]), 0.04, atol=0.045)
    assert (np.abs(estimate.position[1:]) <= np.pi).all()


# Fixes that are late, lost or wrong ---------------------------------------------------------------------------------


def same(a: VerticalEstimate, b: VerticalEstimate) -> None:
    for name in (field.name for field in fields(VerticalEstimate)):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def test_a_late_fix_is_one_after_samples_without() -> None:
    (late, plant), (plain, _) = settled(), settled()
    tau = np.array([5.0, 0.1, 0.1])
    for _ in range(3):
        plant.step(tau)
        plain.step(None, tau, SAMPLE, SETTINGS)
    fix = plant.step(tau) + 0.01
    # 0.8 s less the sample are three samples only to rounding.
    a, b = late.step(fix, tau, 4 * SAMPLE, SETTINGS), plain.step(fix, tau, SAMPLE, SETTINGS)
    for name in ("position", "velocity", "bias", "innovation"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-9, atol=1e-12)
    assert a.status is b.status is ObserverStatus.NOMINAL


def test_a_fix_after_a_gap_counts_for_more() -> None:
    (steady, plant), (lost, _) = settled(), settled()
    for _ in range(10):
        steady.step(plant.step(STILL), None, SAMPLE, SETTINGS)
        lost.step(None, None, SAMPLE, SETTINGS)
    fix = plant.step(STILL) + 0.1
    a, b = steady.step(fix, None, SAMPLE, SETTINGS), lost.step(fix, None, SAMPLE, SETTINGS)
    np.testing.assert_allclose(a.innovation, b.innovation, atol=1e-9)
    assert (np.abs(b.position - fix) < 0.5 * np.abs(a.position - fix)).all()


@pytest.mark.parametrize("name", VESSELS)
@pytest.mark.parametrize("samples", [2, 3, 4, 5, 7, 10, 14, 20, 25])
def test_fixes_that_come_rarely_do_not_excite_the_observer(name: str, samples: int) -> None:
    vessel = load_vessel(name)
    assert vessel.vertical is not None
    gains = vessel.vertical.observer
    found = VerticalObserver(gains, vessel.hull.length, SAMPLE)
    found.step(np.array([0.05, 0.05, 0.05]), None, SAMPLE, SETTINGS)
    largest = []
    for _ in range(60):
        for _ in range(samples - 1):
            found.step(None, None, SAMPLE, SETTINGS)
        largest.append(np.abs(found.step(STILL, None, SAMPLE, SETTINGS).position))
    # Of an error of 0.05 less than a hundredth is left, where a gain for fixes every sample would leave more than there
    # was. Roll is not controlled: what is left of it is its own slow damping.
    assert (largest[-1][[0, 2]] < 0.05 / 100.0).all()
    assert np.array(largest).max() < 0.05


@pytest.mark.parametrize("name", VESSELS)
def test_error_dies_out_under_any_pattern_of_losses(name: str) -> None:
    vessel = load_vessel(name)
    assert vessel.vertical is not None
    found = VerticalObserver(vessel.vertical.observer, vessel.hull.length, SAMPLE)
    chance = np.random.default_rng(7)
    found.step(np.array([0.05, 0.05, 0.05]), None, SAMPLE, SETTINGS)
    for _ in range(1500):
        estimate = found.step(STILL if chance.random() < 0.2 else None, None, SAMPLE, SETTINGS)
    assert (np.abs(estimate.position) < 1e-3).all()


@pytest.mark.parametrize("jump", [(0.6, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, -0.4)])
def test_an_outlier_is_refused_and_one_that_stays_believed(jump: tuple[float, float, float]) -> None:
    found, plant = settled()  # limits: 0.25 of 2 m, 0.35 rad
    for count in range(SETTINGS.reacceptance_count):
        fix = plant.step(STILL) + np.array(jump)
        estimate = found.step(fix, STILL, SAMPLE, SETTINGS)
        assert estimate.status is ObserverStatus.OUTLIER_REFUSED
        np.testing.assert_allclose(estimate.position, plant.state[:, 0], atol=1e-9)
        np.testing.assert_allclose(estimate.innovation, jump, atol=1e-9)
        assert estimate.time_since_measurement == pytest.approx((count + 1) * SAMPLE)
    before = estimate
    fix = plant.step(STILL) + np.array(jump)
    estimate = found.step(fix, STILL, SAMPLE, SETTINGS)
    assert estimate.status is ObserverStatus.REINITIALISED
    np.testing.assert_allclose(estimate.position, fix, atol=1e-15)
    np.testing.assert_allclose(estimate.bias, before.bias, rtol=1e-12)  # a jump says nothing about it


def test_fixes_that_disagree_are_never_believed_and_do_not_keep_the_estimate_valid() -> None:
    found, plant = settled()
    for i in range(26):  # 5.2 s; later any fix is taken
        jump = np.array([(-1.0) ** i * (1.0 + i), 0.0, 0.0])
        estimate = found.step(plant.step(STILL) + jump, STILL, SAMPLE, SETTINGS)
    assert estimate.status is ObserverStatus.INVALID
    assert not estimate.valid
    assert found.step(plant.step(STILL), STILL, SAMPLE, SETTINGS).valid


def test_after_a_loss_any_fix_is_taken() -> None:
    found, plant = settled()
    for _ in range(40):  # 8 s, beyond the limit of 5 s
        estimate = found.step(None, None, SAMPLE, SETTINGS)
    assert estimate.status is ObserverStatus.INVALID
    fix = plant.step(STILL) + 3.0
    fix[1:] = 0.0
    estimate = found.step(fix, None, SAMPLE, SETTINGS)
    assert estimate.status is ObserverStatus.REINITIALISED
    assert estimate.valid
    np.testing.assert_allclose(estimate.position, fix, atol=1e-15)


@pytest.mark.parametrize("gap", [60.0, 1e5, 1e9])
def test_a_gap_of_any_length_is_survived(gap: float) -> None:
    found, _ = settled()
    estimate = found.step(STILL, None, gap, SETTINGS)
    assert estimate.valid
    assert np.isfinite(estimate.position).all()
    for _ in range(400):
        estimate = found.step(STILL, None, SAMPLE, SETTINGS)
    assert np.abs(estimate.position).max() < 1e-3


def test_a_fork_goes_its_own_way() -> None:
    found, plant = settled()
    twin, other = found.fork(), found.fork()
    for _ in range(5):
        twin.step(STILL + 1.0, None, SAMPLE, SETTINGS)
    fix = plant.step(STILL)
    same(found.step(fix, STILL, SAMPLE, SETTINGS), other.step(fix, STILL, SAMPLE, SETTINGS))


# Beside the horizontal plane ----------------------------------------------------------------------------------------


def both(settings: ObserverSettings = SETTINGS) -> Observer:
    found = Observer(load_vessel("ukwial"), settings)
    step(found)
    return found


def step(found: Observer, **parts: Any) -> ObserverEstimate:
    given: dict[str, Any] = {"position": np.zeros(3), "tau": np.zeros(3), "vertical": np.zeros(3)}
    return found.step(ObserverInputs(**(given | parts)), SAMPLE)


def test_the_first_fix_sets_all_axes() -> None:
    found = Observer(load_vessel("ukwial"), SETTINGS)
    estimate = step(found, position=None, vertical=None)
    assert estimate.status is ObserverStatus.UNINITIALISED
    assert not estimate.valid
    estimate = step(found, position=np.array([1.0, 2.0, 3.0]), vertical=np.array([4.0, 0.1, -0.1]))
    assert estimate.status is ObserverStatus.INITIALISED
    assert estimate.valid
    assert estimate.vertical is not None
    np.testing.assert_allclose(estimate.vertical.position, [4.0, 0.1, -0.1], atol=1e-15)  # angles are wrapped


def test_an_outlier_in_depth_leaves_the_plane_alone_and_the_other_way_round() -> None:
    estimate = step(both(), vertical=np.array([5.0, 0.0, 0.0]), position=np.array([0.01, 0.0, 0.0]))
    assert estimate.status is ObserverStatus.OUTLIER_REFUSED
    assert estimate.position[0] > 0.0
    estimate = step(both(), vertical=np.array([0.01, 0.0, 0.0]), position=np.array([5.0, 0.0, 0.0]))
    assert estimate.status is ObserverStatus.OUTLIER_REFUSED
    assert estimate.vertical is not None
    assert estimate.vertical.position[0] > 0.0


@pytest.mark.parametrize("lost", ["position", "vertical"])
def test_an_estimate_is_as_valid_as_the_worse_part(lost: str) -> None:
    found = both()
    for _ in range(26):  # 5.2 s
        estimate = step(found, **{lost: None})
    assert not estimate.valid
    assert estimate.status is ObserverStatus.INVALID
    assert estimate.time_since_measurement == pytest.approx(5.2)
    estimate = step(found)
    assert estimate.valid
    assert estimate.status is ObserverStatus.NOMINAL


@pytest.mark.parametrize(
    ("part", "value", "found"),
    [
        ("vertical", [1.0, 2.0], "depth, roll and pitch: expected shape"),
        ("vertical", [np.nan, 0.0, 0.0], "depth, roll and pitch: expected finite"),
        ("vertical", [1e9, 0.0, 0.0], "depth, roll and pitch: expected numbers within 1e"),
        ("vertical_tau", [0.0, np.inf, 0.0], "tau of heave, roll and pitch: expected finite"),
        ("vertical_tau", [0.0, 0.0, 1e13], "tau of heave, roll and pitch: expected numbers within 1e"),
    ],
)
def test_bad_input_changes_nothing(part: str, value: list[float], found: str) -> None:
    plain, asked = both(), both()
    with pytest.raises(InputError, match=found):
        step(asked, **{part: np.array(value), "position": np.array([0.1, 0.0, 0.0])})
    a, b = step(plain), step(asked)
    np.testing.assert_array_equal(a.position, b.position)
    assert a.vertical is not None
    assert b.vertical is not None
    same(a.vertical, b.vertical)


def test_vessels_on_the_surface_have_no_vertical_part() -> None:
    found = Observer(load_vessel("cybership3"), SETTINGS)
    assert step(found, vertical=np.array([1.0, 0.5, 0.5])).vertical is None


def test_a_fork_of_both_goes_its_own_way() -> None:
    found = both()
    twin = found.fork()
    ahead = step(twin, vertical=np.array([0.1, 0.0, 0.0])).vertical
    assert ahead is not None
    assert ahead.position[0] > 0.0
    stays = step(found).vertical
    assert stays is not None
    assert stays.position[0] == 0.0
