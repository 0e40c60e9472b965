"""Propellers at bollard pull, against the thesis's own figures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel

VESSEL = load_vessel("cybership3")


def test_thrust_of_the_port_propeller_by_hand() -> None:
    """K_T rho D^4 n |n| with K_T = 0.42, D = 0.09 m: 0.42 * 1000 * 6.561e-5 = 0.0275562 N/Hz^2."""
    speed = np.array([0.0, 0.0, 20.0, 0.0])
    assert VESSEL.propellers.thrust(speed)[2] == pytest.approx(0.0275562 * 400.0, rel=1e-12)
    assert VESSEL.propellers.thrust(-speed)[2] == pytest.approx(-0.0275562 * 400.0, rel=1e-12)


@given(thrust=st.tuples(*[st.floats(-14.0, 14.0)] * 4))
def test_shaft_speed_inverts_thrust_and_power_is_torque_times_speed(thrust: tuple[float, ...]) -> None:
    t = np.array(thrust)
    propellers = VESSEL.propellers
    n = propellers.shaft_speed(t)
    np.testing.assert_allclose(propellers.thrust(n), t, rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(propellers.power(t), 2 * np.pi * n * propellers.torque(n), rtol=1e-13, atol=1e-300)


def test_power_at_full_thrust_is_that_of_table_4_2() -> None:
    """K_Q in the file comes from Table 4.2's power through (3.11) at full scale, rho = 1025; here it goes back."""
    table = np.array([0.031, 1.2, 2.6, 2.4]) * 1e6  # W
    scale, density = VESSEL.scale, 1025.0 / VESSEL.density
    full = VESSEL.propellers.power(VESSEL.thrust_max) * scale**3.5 * density
    # Table 4.2 has two digits and calls its column approximate.
    np.testing.assert_allclose(full, table, rtol=0.05)


def test_motors_have_torque_for_full_thrust() -> None:
    needed = VESSEL.propellers.torque(VESSEL.propellers.shaft_speed(VESSEL.thrust_max))
    available = np.array([t.shaft.torque_max for t in VESSEL.thrusters])
    # The file says 1.3 times the torque at T_max, in three digits.
    np.testing.assert_allclose(available / needed, 1.3, rtol=0.01)
