"""A change of law while running is bumpless, for every pair of laws."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from support.thruster_rig import LAWS, ThrusterRig, controllable_pitch_vessel
from thruster_drivers import DriverInputs, DriverOutput, Drivers, DriverSettings
from thruster_drivers.shaft_model import shaft_models

VESSEL = controllable_pitch_vessel()
MODELS = shaft_models(VESSEL)
N = len(MODELS)
DT = VESSEL.simulation.time_step
RATE = VESSEL.thrust_rate
PAIRS = list(permutations(LAWS, 2))


class Sea:
    """All thrusters in a flow, with the drivers around them."""

    def __init__(self, controller: str, advance_speed: float) -> None:
        self.drivers = Drivers(VESSEL, DriverSettings(controller=controller))
        self.rigs = [ThrusterRig(model, advance_speed) for model in MODELS]

    def inputs(self, thrust: FloatArray) -> DriverInputs:
        return DriverInputs(
            thrust,
            np.zeros(N),
            0.0,
            np.array([rig.speed for rig in self.rigs]),
            np.zeros(N),
            np.zeros(N),
            np.array([rig.pitch_ratio for rig in self.rigs]),
        )

    def step(self, thrust: FloatArray) -> DriverOutput:
        output = self.drivers.step(self.inputs(thrust), DT)
        for j, rig in enumerate(self.rigs):
            rig.step(float(output.torque[j]), float(output.pitch_ratio[j]), DT)
        return output


def one_sample(thrust: FloatArray, output: DriverOutput, rigs: list[ThrusterRig]) -> FloatArray:
    """Return how far any law moves its torque in one sample, N m, when the thrust reference goes on to ``thrust``.

    The feedforward's share of the change of reference, with three halves for the optimal pitch's torque and power
    control's up to twice, and for a law of shaft speed its gain times the change of n_d and a sample of its integral.
    """
    found = np.zeros(N)
    gains = VESSEL.drivers.shaft_speed
    for j, (model, rig) in enumerate(zip(MODELS, rigs, strict=True)):
        before = float(output.thrust_reference[j])
        change = float(np.clip(thrust[j] - before, -RATE[j] * DT, RATE[j] * DT))
        per_thrust = model.torque_per_speed_squared / model.thrust_per_speed_squared
        gain = 2.0 * math.pi * model.inertia * gains.bandwidth
        # n_d at the least pitch is 1.5 times that at the design's.
        desired = 1.5 * abs(model.shaft_speed(before + change) - model.shaft_speed(before))
        error = abs(model.shaft_speed(model.thrust_max)) * 1.5 + abs(rig.speed)
        found[j] = 2.0 * per_thrust * abs(change) + gain * (desired + error * DT / gains.integral_time)
    return found


@given(
    pair=st.sampled_from(PAIRS),
    level=st.floats(-0.75, 1.0),
    goal=st.floats(-0.75, 1.0),
    steps=st.integers(1, 60),
    advance_speed=st.floats(-0.3, 0.6),
)
@settings(max_examples=60)
def test_torque_and_pitch_go_on_from_where_they_are(
    pair: tuple[str, str], level: float, goal: float, steps: int, advance_speed: float
) -> None:
    sea = Sea(pair[0], advance_speed)
    for _ in range(steps):
        before = sea.step(level * VESSEL.thrust_max)
    measured = np.array([rig.pitch_ratio for rig in sea.rigs])
    bound = one_sample(goal * VESSEL.thrust_max, before, sea.rigs)
    sea.drivers.apply(DriverSettings(controller=pair[1]))
    after = sea.step(goal * VESSEL.thrust_max)
    assert np.all(np.abs(after.torque - before.torque) <= bound)
    assert np.all(np.abs(after.pitch_ratio - measured) <= 0.4 * DT * (1.0 + 1e-9))  # rate of the actuators
    np.testing.assert_allclose(np.abs(after.thrust_reference - before.thrust_reference) <= RATE * DT * (1 + 1e-9), True)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_at_a_steady_reference_the_laws_of_torque_do_not_move_at_all(pair: tuple[str, str]) -> None:
    sea = Sea(pair[0], 0.4)
    thrust = 0.7 * VESSEL.thrust_max
    for _ in range(60):
        before = sea.step(thrust)
    np.testing.assert_array_equal(before.thrust_reference, thrust)
    speeds = np.array([rig.speed for rig in sea.rigs])
    sea.drivers.apply(DriverSettings(controller=pair[1]))
    after = sea.step(thrust)
    jump = np.abs(after.torque - before.torque)
    if pair[1] in ("shaft_speed", "pitch", "shaft_speed_pitch"):
        # One sample of the integral.
        gains = VESSEL.drivers.shaft_speed
        for j, model in enumerate(MODELS):
            error = abs(after.shaft_speed_reference[j] - speeds[j])
            gain = 2.0 * math.pi * model.inertia * gains.bandwidth
            # Load fed forward follows the pitch, which moves by one sample of its rate: 0.008 of 0.5 at least.
            load = 0.05 * abs(before.torque[j])
            assert jump[j] <= gain * error * DT / gains.integral_time * (1.0 + 1e-9) + load
    else:
        assert np.all(jump <= 1e-12 * np.abs(before.torque) + 1e-15)  # rounding


@pytest.mark.parametrize("name", LAWS)
def test_after_the_change_the_new_law_arrives_where_it_would_have_been(name: str) -> None:
    other = "torque" if name != "torque" else "pitch"
    changed, always = Sea(other, 0.3), Sea(name, 0.3)
    thrust = 0.7 * VESSEL.thrust_max
    for _ in range(50):
        changed.step(thrust)
        always.step(thrust)
    changed.drivers.apply(DriverSettings(controller=name))
    for _ in range(700):
        found, expected = changed.step(thrust), always.step(thrust)
    np.testing.assert_allclose(found.torque, expected.torque, rtol=1e-3)  # 14 s of settling
    np.testing.assert_allclose(found.pitch_ratio, expected.pitch_ratio, rtol=1e-3)


def test_torque_follows_the_pitch_after_pitch_control() -> None:
    """Torque control's torque on a propeller of little pitch would race it."""
    sea = Sea("pitch", 0.0)
    thrust = 0.35 * VESSEL.thrust_max  # at the constant speed: pitch ratio 0.5
    for _ in range(200):
        sea.step(thrust)
    sea.drivers.apply(DriverSettings(controller="torque"))
    top = np.array([rig.speed for rig in sea.rigs])
    for _ in range(200):
        sea.step(thrust)
        assert np.all([rig.speed for rig in sea.rigs] <= top * 1.02)  # the shafts only ever slow down


def test_one_law_for_each_thruster() -> None:
    names = "torque, pitch,shaft_speed , power"
    mixed = Sea(names, 0.0)
    alone = [Sea(name.strip(), 0.0) for name in names.split(",")]
    thrust = 0.6 * VESSEL.thrust_max
    for _ in range(30):
        found = mixed.step(thrust)
        for j, sea in enumerate(alone):
            expected = sea.step(thrust)
            assert found.torque[j] == expected.torque[j]
            assert found.pitch_ratio[j] == expected.pitch_ratio[j]


def test_only_the_thrusters_whose_law_changes_take_over() -> None:
    changed, untouched = Sea("torque_shaft_speed", 0.2), Sea("torque_shaft_speed", 0.2)
    thrust = 0.6 * VESSEL.thrust_max
    for _ in range(30):
        changed.step(thrust)
        untouched.step(thrust)
    law = "torque_shaft_speed"
    changed.drivers.apply(DriverSettings(controller=f"{law},power,{law},{law}"))
    for _ in range(5):
        found, expected = changed.step(thrust), untouched.step(thrust)
    others = [0, 2, 3]
    np.testing.assert_array_equal(found.torque[others], expected.torque[others])
    np.testing.assert_array_equal(found.pitch_ratio[others], expected.pitch_ratio[others])


def test_a_change_of_the_assumed_advance_speed_is_bumpless_too() -> None:
    sea = Sea("torque_pitch", 0.5)
    thrust = 0.6 * VESSEL.thrust_max
    for _ in range(100):
        before = sea.step(thrust)
    sea.drivers.apply(DriverSettings(controller="torque_pitch", advance_speed=0.5))
    after = sea.step(thrust)
    np.testing.assert_allclose(after.torque, before.torque, rtol=1e-12)  # rounding
    for _ in range(300):
        after = sea.step(thrust)
    assert np.all(after.pitch_ratio > before.pitch_ratio + 0.01)


def test_pitch_of_a_start_under_way_and_of_a_lost_sensor() -> None:
    drivers = Drivers(VESSEL, DriverSettings(controller="torque"))
    sea = Sea("torque", 0.0)
    for rig in sea.rigs:
        rig.pitch_ratio = 1.2
    first = drivers.step(sea.inputs(np.zeros(N)), DT)
    np.testing.assert_allclose(first.pitch_ratio, 1.2 - 0.4 * DT)  # to 0.8 at the actuator's rate
    for rig in sea.rigs[:1]:
        rig.pitch_ratio = math.nan
    lost = drivers.step(sea.inputs(np.zeros(N)), DT)
    assert lost.status == "sensor_lost"
    np.testing.assert_allclose(lost.pitch_ratio, 1.2 - 0.8 * DT)
    drivers.apply(DriverSettings(controller="pitch"))
    again = drivers.step(sea.inputs(np.zeros(N)), DT)
    assert np.all(np.isfinite(again.pitch_ratio))
    assert again.pitch_ratio[0] == pytest.approx(lost.pitch_ratio[0] - 0.4 * DT)  # from its own set point


@pytest.mark.parametrize("name", ["pitch", "torque_pitch", "shaft_speed_pitch", "torque_shaft_speed"])
def test_a_law_of_pitch_is_refused_on_a_fixed_one_and_nothing_changes(name: str) -> None:
    vessel = load_vessel("cybership3")
    message = f"controller: expected a law for a fixed pitch at thruster 'tunnel_bow', found '{name}'"
    with pytest.raises(InputError, match=message):
        Drivers(vessel, DriverSettings(controller=name))
    drivers, untouched = Drivers(vessel), Drivers(vessel)
    inputs = DriverInputs(0.5 * vessel.thrust_max, np.zeros(N), 0.0, np.zeros(N), np.zeros(N), np.zeros(N))
    drivers.step(inputs, DT)
    untouched.step(inputs, DT)
    with pytest.raises(InputError, match=message):
        drivers.apply(DriverSettings(controller=name))
    np.testing.assert_array_equal(drivers.step(inputs, DT).torque, untouched.step(inputs, DT).torque)
    np.testing.assert_array_equal(drivers.step(inputs, DT).pitch_ratio, vessel.pitch_ratio)


def test_a_wrong_number_of_laws_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"controller: expected one law, or 4, one a thruster \(tunnel_bow, .* found 2"
    ):
        Drivers(VESSEL, DriverSettings(controller="torque,power"))
