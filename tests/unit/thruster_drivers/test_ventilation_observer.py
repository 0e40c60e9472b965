"""The torque observer: as fast as the noise allows, and not misled by a changing shaft speed."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from marine_model import load_vessel
from marine_model.guards import FloatArray
from thruster_drivers.ventilation import VentilationMonitor, VentilationSettings, tables
from thruster_drivers.ventilation.loss_factor import allowed_noise
from thruster_drivers.ventilation.torque_observer import filter_index

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
AFT = 2
LOAD = float(VESSEL.propellers.torque_per_speed_squared[AFT])
INERTIA = 2.0 * math.pi * VESSEL.thrusters[AFT].shaft.inertia
SUBSTEPS = 20  # Euler steps of 1 ms in the test's own shaft


def shaft(speed: float, torque: float, beta: float, load: float = LOAD) -> float:
    """Return the shaft speed (Hz) after DT, by small steps of the midpoint rule."""
    h = DT / SUBSTEPS
    for _ in range(SUBSTEPS):
        middle = speed + 0.5 * h * (torque - beta * load * speed * abs(speed)) / INERTIA
        speed += h * (torque - beta * load * middle * abs(middle)) / INERTIA
    return speed


class Rig:
    """One aft shaft; the other thrusters stand still."""

    def __init__(self, settings: VentilationSettings | None = None, noise: float = 0.0) -> None:
        self.monitor = VentilationMonitor(VESSEL, settings)
        self.speed = 0.0
        self.random = np.random.default_rng(1)
        self.noise = noise
        self.torque = 0.0
        self.feed()

    def feed(self) -> float:
        measured, torque = np.zeros(4), np.zeros(4)
        measured[AFT] = self.speed + self.noise * self.random.standard_normal()
        torque[AFT] = self.torque
        self.state = self.monitor.step(measured, torque, DT)
        return float(self.state.beta_q[AFT])

    def turn(self, torque: float, beta: float = 1.0) -> float:
        """Hold ``torque`` for a step and return the estimate."""
        self.torque = torque
        self.speed = shaft(self.speed, torque, beta)
        return self.feed()

    def hold(self, speed: float, seconds: float, beta: float = 1.0) -> FloatArray:
        """Hold ``speed`` from now on; return the estimates."""
        self.speed, self.torque = speed, beta * LOAD * speed * abs(speed)
        return np.array([self.feed() for _ in range(round(seconds / DT))])


@given(st.floats(1e-6, 1e3))
def test_the_index_is_the_root_of_its_cubic(x: float) -> None:
    w = filter_index(x)
    if x * x >= 2.0:
        assert w == 1.0  # two measurements are enough
    else:
        assert w >= 1.0 - 1e-12  # rounding at x^2 = 2
        # Relative to the largest term; the cube root has a relative error of 1e-16 or so.
        assert w**3 - 0.5 * w == pytest.approx(1.0 / x**2, rel=1e-12)


def test_without_any_signal_the_index_is_infinite() -> None:
    assert filter_index(0.0) == math.inf


@pytest.mark.parametrize("x", [0.003, 0.03, 0.3, 1.0])
def test_the_gains_are_those_of_a_kalman_filter(x: float) -> None:
    """For the walk whose tracking index the gains belong to, the Riccati equation gives the same gains."""
    w = filter_index(x)
    alpha, gamma = 2.0 / (1.0 + w), 2.0 / (w * (1.0 + w))
    index = gamma / math.sqrt(1.0 - alpha)
    A = np.array([[1.0, 1.0], [0.0, 1.0]])  # shaft speed and its change in a step
    C = np.array([[1.0, 0.0]])
    P = solve_discrete_are(A.T, C.T, np.diag([0.0, index**2]), np.eye(1))
    gain = (P @ C.T / (C @ P @ C.T + 1.0)).ravel()
    np.testing.assert_allclose(gain, [alpha, gamma], rtol=1e-6)  # accuracy of the Riccati solver near a double pole


@pytest.mark.parametrize("speed", [6.0, 10.0, 18.0])
def test_noise_of_the_sensor_leaves_the_allowed_noise_in_beta(speed: float) -> None:
    gains = VESSEL.drivers.ventilation
    assert gains is not None
    allowed = allowed_noise(gains.on, gains.off, gains.false_alarm_interval, DT)
    rig = Rig(noise=VESSEL.measurement.shaft_speed_noise)
    rig.hold(speed, 5.0)
    found = rig.hold(speed, 400.0).std()
    # 20 000 values, correlated over up to 25 steps, leave 3 %. The shaft's own damping, which the gains leave out,
    # makes slow observers up to a fifth quieter.
    assert 0.75 * allowed < found < 1.06 * allowed


def test_interval_of_false_alarms() -> None:
    """(off - on) / s = sqrt(2 ln(1000 h / 20 ms)), worked out by hand: ln(1.8e8) = 19.008, sqrt(38.017) = 6.166."""
    assert allowed_noise(0.5, 0.8, 3.6e6, 0.02) == pytest.approx(0.3 / 6.1658, rel=1e-4)


def test_a_changing_speed_leaves_no_error() -> None:
    """From rest to full ahead, to full astern, and to a stop, with the largest torque of the motor: no loss is seen."""
    rig = Rig()
    limit = VESSEL.thrusters[AFT].shaft.torque_max
    worst = 0.0
    for torque, seconds in ((limit, 1.0), (-limit, 1.0), (limit, 0.2), (0.0, 3.0), (-0.3 * limit, 1.0)):
        for _ in range(round(seconds / DT)):
            worst = max(worst, abs(rig.turn(torque) - 1.0))
    # What the implicit midpoint rule leaves when the speed changes by 1.8 Hz a step.
    assert worst < 0.05


def test_a_sudden_loss_is_seen_within_two_feedbacks_at_speed() -> None:
    rig = Rig()
    speed = 20.0
    rig.hold(speed, 1.0)
    torque = LOAD * speed**2
    assert rig.turn(torque, 0.17) < 0.8
    assert rig.turn(torque, 0.17) < 0.5


def test_the_slower_the_shaft_the_slower_the_observer() -> None:
    """Samples until a loss to 0.17 is seen below 0.5; at the least speed within two samples of the control system."""
    needed = []
    for speed in (20.0, 14.0, 10.0, 7.0, 5.1):
        rig = Rig()
        rig.hold(speed, 2.0)
        for k in range(1, 100):
            rig.torque = 0.17 * LOAD * speed**2  # a controller that keeps the speed
            rig.speed = speed
            if rig.feed() < 0.5:
                needed.append(k)
                break
    assert all(a <= b for a, b in pairwise(needed))
    assert needed[0] <= 2
    assert needed[-1] * DT <= 2 * VESSEL.measurement.sample_time


@pytest.mark.parametrize("method", ["torque_rate", "shaft_deceleration"])
def test_a_shaft_that_turns_over_begins_anew(method: str) -> None:
    """A current that takes half of the torque one way adds to it the other way: no loss is left over from before."""
    rig = Rig(VentilationSettings.model_validate({"method": method}))
    assert rig.hold(-8.0, 2.0, beta=0.5)[-1] == pytest.approx(0.5, abs=1e-6)
    after = []
    for _ in range(60):
        estimate = rig.turn(0.05, beta=0.5 if rig.speed < 0.0 else 1.5)
        if rig.speed > 0.0:
            after.append(estimate)
    assert len(after) > 40
    # The slow form answers for the last whole sample until the next one ends, 0.2 s later.
    assert min(after[10 if method == "shaft_deceleration" else 0 :]) > 1.0 - 1e-6
    assert after[-1] == pytest.approx(1.5, abs=0.05)  # the observer settles


def test_near_rest_a_loss_is_forgotten() -> None:
    rig = Rig()
    rig.hold(20.0, 1.0)
    assert rig.hold(20.0, 0.5, beta=0.2)[-1] == pytest.approx(0.2, abs=0.01)  # settled to a hundredth
    patience = tables.WINDOW * VESSEL.measurement.sample_time
    while rig.speed > 0.5:
        rig.turn(-0.05, 0.2)
    assert rig.monitor.step(np.zeros(4), np.zeros(4), DT).beta_q[AFT] < 0.5  # not yet forgotten
    values = rig.hold(0.0, 5.0 * patience)
    assert values[-1] == pytest.approx(1.0, abs=0.01)  # exp(-5) of 0.8
    assert (np.diff(values) >= 0.0).all()


@given(
    st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(-0.2, 0.2)), min_size=2, max_size=40),
    st.floats(1e-4, 2.0),
    st.sampled_from(["torque_rate", "shaft_deceleration"]),
)
def test_whatever_comes_in_the_loss_factor_is_finite(rows: list[tuple[float, float]], dt: float, method: str) -> None:
    monitor = VentilationMonitor(VESSEL, VentilationSettings.model_validate({"method": method}))
    for speed, torque in rows:
        state = monitor.step(np.full(4, speed), np.full(4, torque), dt)
        assert ((state.beta_q >= 0.0) & (state.beta_q <= 2.0)).all()
        assert np.isfinite(state.torque).all()
        assert np.isfinite(state.shaft_speed).all()
