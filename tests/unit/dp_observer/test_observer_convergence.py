"""Convergence on a simulated vessel in three degrees of freedom."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dp_observer import Observer, ObserverEstimate, ObserverInputs, ObserverSettings
from marine_model import Vessel, load_vessel
from marine_model.frames import rotation, wrap_angle
from marine_model.guards import FloatArray

VESSEL = load_vessel("cybership3")
SAMPLE = VESSEL.measurement.sample_time
BIAS = np.array([1.5, -0.8, 0.3])  # N, N, N m, in map_ned


def sail(
    vessel: Vessel, mass: FloatArray, tau: FloatArray, heading: float, duration: float
) -> tuple[ObserverEstimate, FloatArray, FloatArray]:
    """Return the last estimate and the true position and velocity, under constant ``tau`` and BIAS from rest."""
    damping = np.array(vessel.on_surface()[0].linear_damping)

    def rhs(t: float, x: FloatArray) -> FloatArray:
        r = rotation(x[2])
        nu = x[3:6]
        return np.concatenate([r @ nu, np.linalg.solve(mass, tau + r.T @ BIAS - damping @ nu)])

    count = round(duration / SAMPLE)
    times = SAMPLE * np.arange(count + 1)
    truth = solve_ivp(
        rhs, (0.0, times[-1]), [5.0, -3.0, heading, 0.0, 0.0, 0.0],
        t_eval=times, rtol=1e-10, atol=1e-12, method="DOP853",
    ).y.T  # fmt: skip
    observer = Observer(vessel, ObserverSettings())
    for x in truth:
        fix = np.array([x[0], x[1], wrap_angle(x[2])])
        estimate = observer.step(ObserverInputs(fix, tau), SAMPLE)
    return estimate, truth[-1, 0:3], truth[-1, 3:6]


@pytest.mark.parametrize("heading", [0.0, 0.9, -2.4])
def test_bias_and_velocity_converge(heading: float) -> None:
    """Held in heading against the bias, drifting steadily: the model's own mass."""
    mass = np.array(VESSEL.observer.mass)
    # Yaw moment balances the bias, so that the heading stays.
    tau = np.array([0.4, 0.2, -BIAS[2]])
    # Sway velocity would turn the vessel through the coupling D_32: hold the sway still too.
    tau[1] = -(rotation(heading).T @ BIAS)[1]
    estimate, position, velocity = sail(VESSEL, mass, tau, heading, 400.0)
    assert velocity[2] == pytest.approx(0.0, abs=1e-9)
    # Slowest mode 0.052 1/s: exp(-0.052 * 400) = 1e-9. The plant's damping is the observer's, so nothing else is left
    # but the leak of the bias, T = 1e7 s, worth 1e-7 of its size over K_3 times the innovation it needs.
    np.testing.assert_allclose(estimate.bias, BIAS, atol=1e-5)
    np.testing.assert_allclose(estimate.velocity, velocity, atol=1e-6)
    np.testing.assert_allclose(estimate.position[:2], position[:2], atol=1e-6)
    np.testing.assert_allclose(estimate.wave_frequency_position, 0.0, atol=1e-6)
    np.testing.assert_allclose(estimate.innovation, 0.0, atol=1e-6)


def test_a_wrong_mass_does_not_spoil_the_bias() -> None:
    """App. B tunes M away from the ship's mass; in steady motion mass plays no part."""
    mass = np.array(VESSEL.on_surface()[0].rigid_body_mass) + np.array(VESSEL.on_surface()[0].added_mass)
    tau = np.array([0.4, -(rotation(0.5).T @ BIAS)[1], -BIAS[2]])
    estimate, _, velocity = sail(VESSEL, mass, tau, 0.5, 400.0)
    np.testing.assert_allclose(estimate.bias, BIAS, atol=1e-5)
    np.testing.assert_allclose(estimate.velocity, velocity, atol=1e-6)


def test_estimates_follow_a_turning_vessel() -> None:
    """Turning at 0.1 rad/s, force in the body frame constant, bias in the map constant."""
    mass = np.array(VESSEL.observer.mass)
    tau = np.array([0.7, 0.0, 6.8 * 0.1 - BIAS[2]])
    estimate, position, velocity = sail(VESSEL, mass, tau, 0.0, 300.0)
    assert abs(velocity[2]) > 0.05
    # Here the straight line between fixes and the held heading show: chords of arcs of 0.02 rad a
    # sample, 5e-5 of their radius of about 1 m.
    np.testing.assert_allclose(estimate.bias, BIAS, atol=1e-3)
    np.testing.assert_allclose(estimate.velocity, velocity, atol=1e-4)
    np.testing.assert_allclose(estimate.position[:2], position[:2], atol=5e-4)


def test_turning_the_world_turns_the_estimate() -> None:
    """With gains alike in north and east there is no preferred direction."""
    gains = VESSEL.observer.model_copy(update={"bias_gain": (22.0, 22.0, 25.0)})
    vessel = VESSEL.model_copy(update={"observer": gains})
    random = np.random.default_rng(5)
    angle = 1.1
    turn = rotation(angle)
    one, other = Observer(vessel, ObserverSettings()), Observer(vessel, ObserverSettings())
    for k in range(150):
        fix = np.array([0.2 * np.sin(0.1 * k), 0.1 * np.cos(0.07 * k), 0.05 * k])
        fix += 0.01 * random.standard_normal(3)
        turned = turn @ fix + np.array([0.0, 0.0, angle])
        tau = random.standard_normal(3)
        a = one.step(ObserverInputs(fix, tau), SAMPLE)
        b = other.step(ObserverInputs(turned, tau), SAMPLE)
    # Rounding only.
    np.testing.assert_allclose(b.velocity, a.velocity, atol=1e-12)
    np.testing.assert_allclose(b.bias, turn @ a.bias, atol=1e-11)
    np.testing.assert_allclose(b.position[:2], (turn @ a.position)[:2], atol=1e-12)
    np.testing.assert_allclose(b.wave_frequency_position, turn @ a.wave_frequency_position, atol=1e-12)
