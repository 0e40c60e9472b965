"""The step against an independent integration of the continuous observer, written out from [Ruth] B.3.1."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dp_observer import Observer, ObserverInputs, ObserverSettings, ObserverStatus
from marine_model import Vessel, load_vessel
from marine_model.frames import rotation, wrap_angle
from marine_model.gains import ObserverGains
from marine_model.guards import FloatArray

SAMPLE = 0.2


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


def continuous(
    gains: ObserverGains,
    measured: Callable[[float], FloatArray] | None,
    heading: Callable[[float, FloatArray], float],
    tau: FloatArray,
) -> Callable[[float, FloatArray], FloatArray]:
    """Right-hand side in the unscaled states [eta_w, integral of eta_w, eta, b, nu]."""
    mass, damping = np.array(gains.mass), np.array(gains.damping)
    lam, w0 = np.array(gains.wave_damping), np.array(gains.wave_frequency)
    wc = np.array(gains.cutoff_ratio) * w0
    z = np.array(gains.notch_damping)
    k3, k4 = np.array(gains.bias_gain), np.array(gains.velocity_gain)
    inverse_time = 1.0 / np.array(gains.bias_time_constant)

    def rhs(t: float, x: FloatArray) -> FloatArray:
        eta_w, integral, eta, b, nu = x[0:3], x[3:6], x[6:9], x[9:12], x[12:15]
        r = rotation(heading(t, x))
        y = np.zeros(3) if measured is None else measured(t) - eta - eta_w
        return np.concatenate(
            [
                -2 * lam * w0 * eta_w - w0**2 * integral + 2 * w0 * (z - lam) * y,
                eta_w - 2 * (z - lam) * wc / w0 * y,
                r @ nu + wc * y,
                -inverse_time * b + k3 * y,
                np.linalg.solve(mass, -damping @ nu + r.T @ b + tau + r.T @ (k4 * y)),
            ]
        )

    return rhs


def integrate(rhs: Callable[[float, FloatArray], FloatArray], x: FloatArray, duration: float) -> FloatArray:
    answer = solve_ivp(rhs, (0.0, duration), x, method="DOP853", rtol=1e-12, atol=1e-14)
    return np.asarray(answer.y[:, -1])


def motion(t: float, turn: float = 0.0, waves: float = 1.0) -> FloatArray:
    """A fix with low-frequency motion, waves of 0.8 s, and a steady turn."""
    wave = 2 * np.pi / 0.8
    return np.array(
        [
            0.3 * np.sin(0.2 * t) + waves * 0.06 * np.sin(wave * t),
            0.2 * np.cos(0.15 * t) + waves * 0.02 * np.cos(wave * t),
            0.5 + turn * t + waves * 0.02 * np.sin(wave * t),
        ]
    )


def thrust(k: int) -> FloatArray:
    return np.array([2.0 * np.sin(0.3 * k), np.cos(0.2 * k), 0.3 * np.sin(0.1 * k)])


def reference(
    vessel: Vessel, fixes: list[FloatArray], forces: list[FloatArray], h: float, frozen: bool
) -> list[FloatArray]:
    """States at the fixes, with the fix on a straight line between samples."""
    x = np.zeros(15)
    x[6:9] = fixes[0]
    states = [x]
    for k in range(1, len(fixes)):
        first, last = fixes[k - 1], fixes[k]

        def line(t: float, first: FloatArray = first, last: FloatArray = last) -> FloatArray:
            return first + (last - first) * t / h

        middle = float(line(h / 2)[2])

        def heading(
            t: float,
            x: FloatArray,
            line: Callable[[float], FloatArray] = line,
            middle: float = middle,
        ) -> float:
            return middle if frozen else float(line(t)[2])

        x = integrate(continuous(vessel.observer, line, heading, forces[k]), x, h)
        states.append(x)
    return states


def test_equals_the_continuous_observer_at_held_heading(vessel: Vessel) -> None:
    fixes = [motion(SAMPLE * k) for k in range(80)]
    forces = [thrust(k) for k in range(80)]
    expected = reference(vessel, fixes, forces, SAMPLE, frozen=True)
    observer = Observer(vessel, ObserverSettings())
    for fix, tau, x in zip(fixes, forces, expected, strict=True):
        estimate = observer.step(ObserverInputs(fix, tau), SAMPLE)
        # The integrator keeps 1e-12 a step relative to states of order 1; errors of 80 steps decay, so 1e-10 is ample.
        np.testing.assert_allclose(estimate.wave_frequency_position, x[0:3], atol=1e-10)
        np.testing.assert_allclose(estimate.position, x[6:9], atol=1e-10)
        np.testing.assert_allclose(estimate.bias, x[9:12], atol=1e-9)  # newtons, tens of them per metre
        np.testing.assert_allclose(estimate.velocity, x[12:15], atol=1e-10)


@pytest.mark.parametrize("h", [0.01, 0.07, 0.2, 0.29])
def test_any_step_length_is_exact(vessel: Vessel, h: float) -> None:
    fixes = [motion(h * k) for k in range(20)]
    forces = [thrust(k) for k in range(20)]
    expected = reference(vessel, fixes, forces, h, frozen=True)
    observer = Observer(vessel, ObserverSettings())
    for fix, tau in zip(fixes, forces, strict=True):
        estimate = observer.step(ObserverInputs(fix, tau), h)
    np.testing.assert_allclose(estimate.velocity, expected[-1][12:15], atol=1e-10)
    np.testing.assert_allclose(estimate.position, expected[-1][6:9], atol=1e-10)


def test_holding_the_heading_is_of_second_order(vessel: Vessel) -> None:
    """In a turn the step differs from the observer with moving heading by an error that falls with h^2."""
    errors = []
    for h in (0.2, 0.1, 0.05):
        count = round(8.0 / h)
        # The reference sees the same straight lines between fixes: the held heading is the one difference.
        fixes = [motion(h * k, turn=0.3, waves=0.0) for k in range(count + 1)]
        forces = [np.array([2.0, 1.0, 0.2])] * (count + 1)
        expected = reference(vessel, fixes, forces, h, frozen=False)
        observer = Observer(vessel, ObserverSettings())
        error = 0.0
        for k, (fix, tau, x) in enumerate(zip(fixes, forces, expected, strict=True)):
            estimate = observer.step(ObserverInputs(fix, tau), h)
            if k % round(0.2 / h) == 0:
                error = max(error, float(np.abs(estimate.velocity - x[12:15]).max()))
        errors.append(error)
    # A factor of 4 a halving in the limit; 3 leaves room for the terms beyond it.
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[0] < 1e-3  # m/s, a hundredth of the vessel's speed limit


def test_prediction_without_fix_equals_the_model(vessel: Vessel) -> None:
    observer = Observer(vessel, ObserverSettings())
    for k in range(60):
        observer.step(ObserverInputs(motion(SAMPLE * k), thrust(k)), SAMPLE)
    before = observer.step(ObserverInputs(motion(SAMPLE * 60), thrust(60)), SAMPLE)
    x = np.zeros(15)
    x[0:3], x[6:9] = before.wave_frequency_position, before.position
    x[9:12], x[12:15] = before.bias, before.velocity
    tau = np.array([1.0, -2.0, 0.1])
    heading = x[8] + 0.5 * SAMPLE * x[14]
    # The integral of the wave motion is not an output; it moves the wave-frequency position only.
    x = integrate(continuous(vessel.observer, None, lambda t, x: heading, tau), x, SAMPLE)
    after = observer.step(ObserverInputs(None, tau), SAMPLE)
    assert after.status is ObserverStatus.DEAD_RECKONING
    np.testing.assert_allclose(after.position, x[6:9], atol=1e-12)
    np.testing.assert_allclose(after.bias, x[9:12], atol=1e-12)
    np.testing.assert_allclose(after.velocity, x[12:15], atol=1e-12)


def test_heading_held_at_zero_has_the_notch_of_the_design(vessel: Vessel) -> None:
    """(B.11) with -omega_0^2: y~/y has the wave model's zeros and the notch's poles when nu is not fed back."""
    g = vessel.observer
    w0, lam, z = g.wave_frequency[0], g.wave_damping[0], g.notch_damping[0]
    wc = g.cutoff_ratio[0] * w0
    a = np.array([[-2 * lam * w0, -(w0**2), 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    k = np.array([2 * w0 * (z - lam), -2 * (z - lam) * wc / w0, wc])
    c = np.array([1.0, 0.0, 1.0])
    for s in (0.3j, 4.66j, 7.85j, 1.0 + 2.0j):
        transfer = 1.0 / (1.0 + c @ np.linalg.solve(s * np.eye(3) - a, k))
        notch = (s**2 + 2 * lam * w0 * s + w0**2) / (s**2 + 2 * z * w0 * s + w0**2)
        assert transfer == pytest.approx(notch * s / (s + wc), rel=1e-12)
    # The printed sign would put a pole of the wave model in the right half plane.
    printed = np.array([[-2 * lam * w0, w0**2], [1.0, 0.0]])
    assert np.linalg.eigvals(printed).real.max() > 0.0
    assert np.linalg.eigvals(a[:2, :2]).real.max() < 0.0


def test_heading_wraps_without_a_trace(vessel: Vessel) -> None:
    """The same turn, told as an angle that wraps and as one that does not, gives the same estimate."""
    one, other = Observer(vessel, ObserverSettings()), Observer(vessel, ObserverSettings())
    seen = []
    for k in range(200):
        fix = motion(SAMPLE * k, turn=0.25)
        fix[2] += 2.0
        turned = fix.copy()
        turned[2] = wrap_angle(float(fix[2]))
        seen.append(turned[2])
        a = one.step(ObserverInputs(fix, np.zeros(3)), SAMPLE)
        b = other.step(ObserverInputs(turned, np.zeros(3)), SAMPLE)
        assert a.status == b.status != ObserverStatus.OUTLIER_REFUSED
        # The wrap rounds at 1e-16 of angles up to 12 rad; decaying errors never add up beyond 1e-12.
        np.testing.assert_allclose(a.velocity, b.velocity, atol=1e-12)
        np.testing.assert_allclose(a.position, b.position, atol=1e-12)
        assert -np.pi <= a.position[2] < np.pi
        assert abs(a.innovation[2]) < 0.2
    assert max(np.abs(np.diff(seen))) > 6.0  # the angle did wrap
