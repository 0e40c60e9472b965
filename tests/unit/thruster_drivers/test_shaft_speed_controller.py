"""PI on shaft speed against a simulated shaft, 2 pi J dn/dt = Q_m - Q_p - Q_f."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from marine_model import load_vessel
from thruster_drivers.controllers import ShaftSpeedController, tuning_of
from thruster_drivers.shaft_model import ShaftModel, shaft_models

VESSEL = load_vessel("cybership3")
MODELS = shaft_models(VESSEL)
GAINS = VESSEL.drivers.shaft_speed
TUNING = tuning_of(VESSEL.drivers, 0)
PITCH = math.nan  # fixed: not looked at
DT = VESSEL.simulation.time_step
SUBSTEPS = 20  # of the simulated shaft in one control step


class Shaft:
    """The truth: what the controller's model says, but for a load factor and the friction given here."""

    def __init__(self, model: ShaftModel, load_factor: float = 1.0, friction: float = 0.0) -> None:
        self.model = model
        self.load_factor = load_factor
        self.friction = friction
        self.speed = 0.0

    def step(self, torque: float, dt: float) -> None:
        for _ in range(SUBSTEPS):
            load = self.load_factor * self.model.torque_per_speed_squared * self.speed * abs(self.speed)
            load += self.friction * math.tanh(self.speed / 0.01)  # smooth sign over 0.01 Hz
            self.speed += (torque - load) / (2.0 * math.pi * self.model.inertia) * dt / SUBSTEPS


def run(controller: ShaftSpeedController, shaft: Shaft, thrust: float, seconds: float) -> list[float]:
    torques = []
    for _ in range(round(seconds / DT)):
        torques.append(controller.step(thrust, shaft.speed, PITCH, DT).torque)
        shaft.step(torques[-1], DT)
    return torques


@pytest.mark.parametrize("model", MODELS, ids=VESSEL.thruster_names)
@pytest.mark.parametrize("share", [0.3, 1.0, -0.4])
def test_shaft_reaches_the_desired_speed(model: ShaftModel, share: float) -> None:
    thrust = share * model.thrust(44.0 if model is MODELS[0] else 17.0)
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model)
    run(controller, shaft, thrust, 3.0)
    # 3 s are 15 integral times: what is left of the slowest mode is below 1e-5 of the step.
    assert shaft.speed == pytest.approx(model.shaft_speed(thrust), rel=1e-4)


@pytest.mark.parametrize("model", MODELS, ids=VESSEL.thruster_names)
def test_bandwidth_is_that_of_the_vessel_file_whatever_the_inertia(model: ShaftModel) -> None:
    """Small step about a working point: omega_b = 20 1/s with T_i = 4/omega_b gives a peak at once, then decay."""
    thrust = model.thrust(10.0)
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model)
    run(controller, shaft, thrust, 3.0)
    higher = model.thrust(10.2)
    run(controller, shaft, higher, 1.0 / GAINS.bandwidth)
    # A first-order loop would have gone 1 - 1/e = 63 %; feedforward and integral only add to that, and
    # overshoot of a critically damped pair with this zero is below 14 %; sampling at 0.4/omega_b adds some.
    assert 0.6 < (shaft.speed - 10.0) / 0.2 < 1.35
    run(controller, shaft, higher, 1.0)
    assert shaft.speed == pytest.approx(10.2, abs=0.2 * 0.02)


def test_integral_takes_up_a_load_that_the_feedforward_does_not_know() -> None:
    model = MODELS[2]
    thrust = model.thrust(15.0)
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model, load_factor=0.7)
    run(controller, shaft, thrust, 3.0)
    assert shaft.speed == pytest.approx(15.0, rel=1e-4)  # as above: the transient is gone
    # In steady state the integral is the whole difference: -30 % of the nominal torque.
    assert controller.integral == pytest.approx(-0.3 * model.load_torque(15.0), rel=1e-3)


def test_friction_is_compensated_without_the_integral() -> None:
    model = replace(MODELS[2], friction_static=0.01)
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model, friction=0.01)
    run(controller, shaft, model.thrust(-12.0), 3.0)
    assert shaft.speed == pytest.approx(-12.0, rel=1e-4)
    assert abs(controller.integral) < 1e-5  # 0.1 % of the friction


@pytest.mark.parametrize("model", MODELS, ids=VESSEL.thruster_names)
def test_torque_stays_within_the_motor_limit_in_a_full_reversal(model: ShaftModel) -> None:
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model)
    full = model.thrust(40.0 if model is MODELS[0] else 16.0)
    torques = run(controller, shaft, full, 2.0) + run(controller, shaft, -full, 2.0)
    assert max(map(abs, torques)) == model.torque_max  # the reversal needs all there is


def test_integral_does_not_wind_up_at_the_torque_limit() -> None:
    """A shaft held fast for ten seconds must not take longer to settle than one held for half a second."""
    model = MODELS[1]
    thrust = model.thrust(30.0)

    def overshoot(held: float) -> float:
        controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model)
        for _ in range(round(held / DT)):
            assert controller.step(thrust, 0.0, PITCH, DT).torque == model.torque_max
        peak = 0.0
        for _ in range(round(3.0 / DT)):
            shaft.step(controller.step(thrust, shaft.speed, PITCH, DT).torque, DT)
            peak = max(peak, shaft.speed)
        assert shaft.speed == pytest.approx(30.0, rel=1e-3)
        return peak - 30.0

    assert overshoot(10.0) == pytest.approx(overshoot(0.5), abs=1e-9)  # the same path, so the same but for rounding


def test_lost_shaft_speed_leaves_feedforward_and_the_integral_found_so_far() -> None:
    model = MODELS[2]
    thrust = model.thrust(15.0)
    controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model, load_factor=0.9)
    run(controller, shaft, thrust, 3.0)
    for lost in (math.nan, math.inf, -math.inf):
        torque = controller.step(thrust, lost, PITCH, DT).torque
        assert torque == pytest.approx(0.9 * model.load_torque(15.0), rel=1e-3)  # settled as above
        shaft.step(torque, DT)
    assert shaft.speed == pytest.approx(15.0, rel=1e-3)


def test_a_gap_in_the_measurements_does_not_kick_the_integral() -> None:
    model = MODELS[1]
    controller = ShaftSpeedController(model, TUNING)
    gain = 2.0 * math.pi * model.inertia * GAINS.bandwidth
    controller.step(model.thrust(5.0), 4.9, PITCH, 60.0)
    assert controller.integral == pytest.approx(gain * 0.1)  # one integral time's worth, not 60 s


def test_noise_on_the_measured_speed_stays_small_in_torque() -> None:
    rng = np.random.default_rng(1)
    noise = VESSEL.measurement.shaft_speed_noise
    for model in MODELS:
        controller, shaft = ShaftSpeedController(model, TUNING), Shaft(model)
        thrust = model.thrust(12.0)
        run(controller, shaft, thrust, 3.0)
        torques = []
        for _ in range(500):
            torques.append(controller.step(thrust, shaft.speed + noise * rng.standard_normal(), PITCH, DT).torque)
            shaft.step(torques[-1], DT)
        # K_p times the noise, and what the loop feeds back of it: less than half as much again.
        gain = 2.0 * math.pi * model.inertia * GAINS.bandwidth
        assert np.std(torques) < 1.5 * gain * noise
        assert np.std(torques) > 0.5 * gain * noise
