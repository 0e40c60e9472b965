"""Torque, power and shaft speed stay within the limits of motor and shaft, whatever the law."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.thruster_rig import LAWS, ThrusterRig, controllable_pitch_vessel
from thruster_drivers.controllers import make_controller, tuning_of
from thruster_drivers.controllers.limits import ShaftLimits
from thruster_drivers.shaft_model import shaft_models

VESSEL = controllable_pitch_vessel()
PLAIN = shaft_models(VESSEL)[2]
TUNING = tuning_of(VESSEL.drivers, 2)
TOP = PLAIN.shaft_speed(PLAIN.thrust_max)
POWER = 2.0 * math.pi * TOP * PLAIN.load_torque(TOP)
# The best pitch ratio at bollard pull, 0.60, needs 1.2 times the shaft speed of the design's, 0.8.
LIMITED = replace(PLAIN, power_max=1.05 * POWER, speed_max=1.25 * TOP)
DT = 0.02


@given(
    st.sampled_from(LAWS),
    st.lists(
        st.tuples(st.floats(-20.0, 20.0), st.one_of(st.floats(-60.0, 60.0), st.just(math.nan))), min_size=1, max_size=20
    ),
)
def test_no_history_passes_the_limits_of_torque_and_power(name: str, history: list[tuple[float, float]]) -> None:
    controller = make_controller(name, LIMITED, TUNING)
    for thrust, speed in history:
        output = controller.step(thrust, speed, 0.8, DT)
        assert abs(output.torque) <= LIMITED.torque_max
        n = speed if math.isfinite(speed) else controller.shaft_speed_reference
        assert abs(2.0 * math.pi * n * output.torque) <= LIMITED.power_max * (1.0 + 1e-12)  # rounding


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_propeller_that_loses_its_load_is_held_at_the_speed_limit(name: str, sign: float) -> None:
    controller, rig = make_controller(name, LIMITED, TUNING), ThrusterRig(LIMITED)
    thrust = sign * 0.8 * LIMITED.thrust_max
    speeds = []
    for k in range(700):
        rig.load_factor = 1.0 if k < 300 else 0.15  # a propeller in air has about this much left
        rig.step(*controller.step(thrust, rig.speed, rig.pitch_ratio, DT), DT)
        speeds.append(sign * rig.speed)
    assert max(speeds[:300]) <= LIMITED.speed_max * (1.0 + 1e-9)  # rounding
    # Load that goes at once lets the loop of 20 1/s pass the limit by what it loses over K_p, for two integral times.
    assert max(speeds) < LIMITED.speed_max * 1.4
    assert speeds[-1] <= LIMITED.speed_max * (1.0 + 1e-3)  # 8 s are 40 integral times
    if name == "torque":
        unlimited, free = make_controller(name, PLAIN, TUNING), ThrusterRig(PLAIN)
        free.load_factor = 0.15
        for _ in range(400):
            free.step(*unlimited.step(thrust, free.speed, free.pitch_ratio, DT), DT)
        assert sign * free.speed > 1.5 * LIMITED.speed_max  # it would have raced


@pytest.mark.parametrize("name", LAWS)
def test_speed_limit_leaves_the_largest_thrust_alone(name: str) -> None:
    limited, free = make_controller(name, LIMITED, TUNING), make_controller(name, PLAIN, TUNING)
    rigs = ThrusterRig(LIMITED), ThrusterRig(PLAIN)
    for _ in range(500):
        for controller, rig in zip((limited, free), rigs, strict=True):
            rig.step(*controller.step(0.98 * PLAIN.thrust_max, rig.speed, rig.pitch_ratio, DT), DT)
    assert rigs[0].speed == pytest.approx(rigs[1].speed, rel=1e-3)  # settled to that after 10 s
    assert rigs[0].thrust == pytest.approx(0.98 * PLAIN.thrust_max, rel=2e-3)


def test_bounds_by_hand() -> None:
    """Q_max = 4, P_max = 2 pi 20, n_max = 10, load at n_max 3, K_p = 2 pi J omega_b = 2, T_i = 0.5."""
    model = replace(
        PLAIN,
        torque_max=4.0,
        power_max=2.0 * math.pi * 20.0,
        speed_max=10.0,
        torque_per_speed_squared=0.03,
        inertia=1.0 / (2.0 * math.pi),
    )
    limits = ShaftLimits(model, replace(TUNING, bandwidth=2.0, integral_time=0.5))
    assert limits.bounds(2.0, 0.1) == (-4.0, 4.0)
    assert limits.bounds(8.0, 0.1) == (-2.5, 2.5)  # power: 20 / 8
    assert limits.bounds(-8.0, 0.1) == (-2.5, 2.5)
    low, high = limits.bounds(11.0, 0.1)
    assert low == pytest.approx(-20.0 / 11.0)
    assert high == pytest.approx(3.0 - 2.0 - 0.4)  # load - K_p 1 - K_p / T_i 1 0.1
    assert limits.bounds(11.0, 0.1)[1] == pytest.approx(0.2)
    # Half a sample's worth of room gives back as much of the integral.
    assert limits.bounds(9.5, 0.1)[1] == pytest.approx(min(20.0 / 9.5, 3.0 + 1.0 - 0.8 + 0.2))
    assert limits.bounds(0.0, 0.1) == (-4.0, 4.0)


def test_without_limits_of_power_and_speed_the_bounds_are_constant() -> None:
    assert ShaftLimits(PLAIN, TUNING).constant == (-PLAIN.torque_max, PLAIN.torque_max)
    assert ShaftLimits(LIMITED, TUNING).constant is None


def test_a_speed_limit_bounds_the_desired_speed() -> None:
    controller = make_controller("shaft_speed", LIMITED, TUNING)
    for sign in (1.0, -1.0):
        controller.step(sign * 3.0 * LIMITED.thrust_max, 0.0, 0.8, DT)
        assert controller.shaft_speed_reference == sign * LIMITED.speed_max
