"""Thrust to shaft speed and load torque, by hand for CyberShip III."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from thruster_drivers.shaft_model import ShaftModel, shaft_models

VESSEL = load_vessel("cybership3")
MODELS = dict(zip(VESSEL.thruster_names, shaft_models(VESSEL), strict=True))


@pytest.mark.parametrize(
    ("name", "thrust", "shaft_speed"),
    [
        # sqrt(8.7 / (0.52 * 1000 * 0.06^4)) = sqrt(1290.95), [Ruth] (3.8) with (B.23), (B.34)-(B.36)
        ("azimuth_bow", 8.7, 35.93),
        ("azimuth_bow", -4.7, -26.41),  # sqrt(697.41)
        ("tunnel_bow", 0.58, 44.60),  # sqrt(0.58 / 2.916e-4) = sqrt(1989.03)
        ("azimuth_port", 13.5, 22.13),  # sqrt(13.5 / 0.0275562) = sqrt(489.91)
        ("azimuth_starboard", -9.0, -17.27),  # sqrt(9 / 0.0301806) = sqrt(298.20)
    ],
)
def test_shaft_speed_of_thrust_by_hand(name: str, thrust: float, shaft_speed: float) -> None:
    # The hand values carry two decimals.
    assert MODELS[name].shaft_speed(thrust) == pytest.approx(shaft_speed, abs=0.005)


def test_no_thrust_is_no_shaft_speed_and_no_load() -> None:
    for model in MODELS.values():
        assert model.shaft_speed(0.0) == 0.0
        assert model.load_torque(0.0) == 0.0


def test_agrees_with_the_shared_propeller_model() -> None:
    thrust = np.array([0.3, -2.0, 7.0, -5.0])
    speed = VESSEL.propellers.shaft_speed(thrust)
    torque = VESSEL.propellers.torque(speed)
    for j, model in enumerate(MODELS.values()):
        assert model.shaft_speed(thrust[j]) == pytest.approx(speed[j], rel=1e-12)  # same formula, rounding only
        assert model.load_torque(speed[j]) == pytest.approx(torque[j], rel=1e-12)


@given(st.floats(-13.0, 13.0))
def test_thrust_and_shaft_speed_are_inverse(thrust: float) -> None:
    for model in MODELS.values():
        # Rounding only; the absolute part is for thrusts whose square underflows.
        assert model.thrust(model.shaft_speed(thrust)) == pytest.approx(thrust, rel=1e-12, abs=1e-300)


def test_friction_opposes_the_shaft_either_way() -> None:
    model = ShaftModel(
        thrust_per_speed_squared=1.0,
        torque_per_speed_squared=0.0,
        inertia=1.0,
        torque_max=10.0,
        friction_static=0.5,
        friction_viscous=0.1,
    )
    assert model.load_torque(2.0) == pytest.approx(0.7)
    assert model.load_torque(-2.0) == pytest.approx(-0.7)
    assert math.copysign(1.0, model.load_torque(1e-9)) == 1.0
