"""Torque, power and combined control, [Ruth] (3.10)-(3.14), by hand for the propeller of section 3.7."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.thruster_rig import ThrusterRig, controllable_pitch_vessel
from thruster_drivers.controllers import (
    CombinedController,
    PowerController,
    TorqueController,
    Tuning,
    make_controller,
    tuning_of,
)
from thruster_drivers.shaft_model import ShaftModel, shaft_models

# [Ruth] 3.7: D = 4 m, K_Tc = 0.2394, K_Qc = 0.0226, 5000 N m/(Hz/s); rho = 1025 kg/m^3.
DENSITY, DIAMETER = 1025.0, 4.0
MODEL = ShaftModel(
    thrust_per_speed_squared=0.2394 * DENSITY * DIAMETER**4,
    torque_per_speed_squared=0.0226 * DENSITY * DIAMETER**5,
    inertia=5000.0 / (2.0 * math.pi),
    torque_max=1e6,
    friction_static=0.0,
    friction_viscous=0.0,
    thrust_max=300e3,
    density=DENSITY,
    pitch_ratio=0.58,
)
# k, p and r of (3.14) as printed.
TUNING = Tuning(200.0, 1.0 / (2.0 * math.pi), 0.2, combined_gain=1.0, combined_time=0.5, combined_exponent=20.0)
PITCH = 0.58
DT = 0.01
TORQUE, POWER, COMBINED = (law(MODEL, TUNING) for law in (TorqueController, PowerController, CombinedController))


def test_torque_by_hand_and_for_either_sign() -> None:
    # 0.0226 * 4 / 0.2394 * 200e3 = 75 522 N m, whatever the shaft does.
    for speed in (0.0, 1.0, 3.0, -1.0, math.nan):
        assert TORQUE.step(200e3, speed, PITCH, DT).torque == pytest.approx(75522.1, abs=0.1)
        assert TORQUE.step(-200e3, speed, PITCH, DT).torque == pytest.approx(-75522.1, abs=0.1)
    # sqrt(200e3 / (0.2394 * 1025 * 256)) = 1.7843 Hz
    assert TORQUE.shaft_speed_reference == pytest.approx(-1.7843, abs=1e-4)
    assert TORQUE.step(200e3, 0.0, PITCH, DT).pitch_ratio == 0.58


def test_power_by_hand_and_for_either_sign() -> None:
    # (3.11): 2 pi 0.0226 / (sqrt(1025) 4 0.2394^1.5) 200e3^1.5 = 846.7 kW
    assert 2.0 * math.pi * 0.0226 / (math.sqrt(1025.0) * 4.0 * 0.2394**1.5) * 200e3**1.5 == pytest.approx(
        846.7e3, abs=50
    )
    for speed in (1.0, 1.5, 1.7843, 2.5, 6.0):
        torque = POWER.step(200e3, speed, PITCH, DT).torque
        assert 2.0 * math.pi * speed * torque == pytest.approx(846.7e3, abs=50.0)  # four digits
        assert POWER.step(-200e3, -speed, PITCH, DT).torque == -torque


@given(st.floats(1e3, 3e5), st.floats(-0.5, 0.5))
def test_power_has_an_end_where_the_shaft_stands_or_turns_the_other_way(thrust: float, share: float) -> None:
    desired = MODEL.shaft_speed(thrust)
    bound = 2.0 * TORQUE.step(thrust, 0.0, PITCH, DT).torque
    # Below half of the desired speed twice the torque of torque control, up to rounding at one half.
    speed = share * desired
    assert POWER.step(thrust, speed, PITCH, DT).torque == pytest.approx(bound, rel=1e-12)
    assert POWER.step(-thrust, -speed, PITCH, DT).torque == pytest.approx(-bound, rel=1e-12)


def test_power_without_thrust_or_without_sensor() -> None:
    for speed in (0.0, 2.0, -2.0, math.nan):
        assert POWER.step(0.0, speed, PITCH, DT).torque == 0.0
    for lost in (math.nan, math.inf):
        assert POWER.step(1e5, lost, PITCH, DT).torque == TORQUE.step(1e5, lost, PITCH, DT).torque


def test_combined_is_torque_control_at_low_and_power_control_at_high_speed() -> None:
    thrust = 200e3
    for speed in (0.3, 1.0, 1.4):
        # alpha(1.4) = exp(-0.7^20) = 0.9992
        expected = TORQUE.step(thrust, speed, PITCH, DT).torque
        assert COMBINED.step(thrust, speed, PITCH, DT).torque == pytest.approx(expected, rel=2e-3)
    for speed in (2.3, 3.0, 1e300):
        # alpha(2.3) = exp(-1.15^20) = 8e-8
        expected = POWER.step(thrust, speed, PITCH, DT).torque
        assert COMBINED.step(thrust, speed, PITCH, DT).torque == pytest.approx(expected, rel=1e-6)
    # alpha(2) = 1/e by (3.14): 0.3679 * 75 522 + 0.6321 * 846.7e3 / (2 pi 2) = 70 373
    assert COMBINED.step(thrust, 2.0, PITCH, DT).torque == pytest.approx(70373.0, abs=5.0)
    assert COMBINED.step(-thrust, -2.0, PITCH, DT).torque == pytest.approx(-70373.0, abs=5.0)


def test_combined_crosses_at_half_of_the_largest_thrust_unless_told() -> None:
    law = CombinedController(MODEL, replace(TUNING, combined_time=None))
    crossing = MODEL.shaft_speed(150e3)
    torque, power = (other.step(2e5, crossing, PITCH, DT).torque for other in (TORQUE, POWER))
    expected = power + math.exp(-1.0) * (torque - power)
    assert law.step(2e5, crossing, PITCH, DT).torque == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("law", [TorqueController, PowerController, CombinedController])
@pytest.mark.parametrize("thrust", [150e3, -150e3])
def test_friction_is_added_with_the_sign_of_thrust(law: type[TorqueController], thrust: float) -> None:
    rough = replace(MODEL, friction_static=700.0, friction_viscous=300.0)
    desired = MODEL.shaft_speed(thrust)
    for speed in (0.0, desired, 0.7 * desired, math.nan):
        more = (
            law(rough, TUNING).step(thrust, speed, PITCH, DT).torque
            - law(MODEL, TUNING).step(thrust, speed, PITCH, DT).torque
        )
        assert more == pytest.approx(math.copysign(700.0 + 300.0 * abs(desired), thrust))


VESSEL = controllable_pitch_vessel()
B_SERIES = shaft_models(VESSEL)[2]


@pytest.mark.parametrize("name", ["torque", "power", "combined"])
@pytest.mark.parametrize("advance_speed", [0.0, 0.4])
def test_what_is_controlled_is_kept_whatever_the_flow(name: str, advance_speed: float) -> None:
    """At J = 0 all three give exactly the desired thrust; in a flow torque or power is kept, [Ruth] (3.35), (3.41)."""
    controller = make_controller(name, B_SERIES, tuning_of(VESSEL.drivers, 2))
    rig = ThrusterRig(B_SERIES, advance_speed)
    thrust = 12.0
    for _ in range(400):
        output = controller.step(thrust, rig.speed, rig.pitch_ratio, 0.02)
        rig.step(*output, 0.02)
    desired = B_SERIES.shaft_speed(thrust)
    load = B_SERIES.load_torque(desired)
    # 8 s are more than 20 time constants of the slowest shaft; the rest is the rounding of its steps.
    if advance_speed == 0.0:
        assert rig.thrust == pytest.approx(thrust, rel=1e-6)
        assert rig.speed == pytest.approx(desired, rel=1e-6)
    else:
        assert rig.speed > 1.02 * desired  # the flow unloads the propeller
    if name == "torque":
        assert rig.torque == pytest.approx(load, rel=1e-6)
    if name == "power":
        assert rig.speed * rig.torque == pytest.approx(desired * load, rel=1e-6)
    if name == "combined":
        assert load * desired / rig.speed * (1.0 - 1e-6) <= rig.torque <= load * (1.0 + 1e-6)
