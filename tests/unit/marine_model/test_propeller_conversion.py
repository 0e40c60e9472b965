"""Conversions between coefficients: exact inverses, and cases by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.propellers import conversion

J = st.floats(-3.0, 3.0)
K = st.floats(-2.0, 2.0)


@given(advance=J, k=K)
def test_open_water_and_four_quadrant_coefficients_are_inverses(advance: float, k: float) -> None:
    there = conversion.four_quadrant_coefficients(k, advance)
    back = float(conversion.open_water_coefficients(there, advance))
    assert back == pytest.approx(k, rel=4e-16, abs=1e-300)  # one division and one product


@given(advance=J)
def test_advance_number_and_angle_are_inverses(advance: float) -> None:
    back = float(conversion.advance_number_of(conversion.advance_angle_of(advance)))
    # Near 54 deg, J = 3, an angle's rounding counts (1 + tan^2) times.
    assert back == pytest.approx(advance, rel=1e-15, abs=1e-15)


@given(n=st.floats(0.1, 50.0), speed=st.floats(-5.0, 5.0), thrust=st.floats(-100.0, 100.0), D=st.floats(0.01, 5.0))
def test_both_definitions_give_the_same_thrust(n: float, speed: float, thrust: float, D: float) -> None:
    """(2.9) and (2.13) of one force, joined by (2.17) and by (2.11)-(2.12), (2.19)."""
    rho = 1025.0
    advance = conversion.advance_number(speed, n, D)
    k_t = conversion.thrust_coefficient(thrust, n, D, rho)
    c_t = thrust / conversion.four_quadrant_scale(n, speed, D, rho)
    assert float(conversion.open_water_coefficients(c_t, advance)) == pytest.approx(float(k_t), rel=1e-13, abs=1e-300)
    angle = conversion.advance_angle(speed, n, D)
    assert float(conversion.advance_angle_of(advance)) == pytest.approx(float(angle), rel=1e-14)


def test_by_hand() -> None:
    """n = 2 Hz, D = 0.5 m, V_A = 0.6 m/s, T = 100 N, Q = 8 N m, rho = 1000."""
    assert float(conversion.advance_number(0.6, 2.0, 0.5)) == pytest.approx(0.6)
    assert float(conversion.thrust_coefficient(100.0, 2.0, 0.5, 1000.0)) == pytest.approx(0.4)  # 100 / (1000/16 * 4)
    assert float(conversion.torque_coefficient(8.0, 2.0, 0.5, 1000.0)) == pytest.approx(0.064)  # 8 / (1000/32 * 4)
    assert float(conversion.efficiency(0.6, 0.4, 0.064)) == pytest.approx(0.6 * 0.4 / (2.0 * math.pi * 0.064))
    assert float(conversion.power(2.0, 8.0)) == pytest.approx(32.0 * math.pi)
    assert float(conversion.inflow_speed(0.6, 2.0, 0.5)) == pytest.approx(math.hypot(0.6, 0.7 * math.pi))


@pytest.mark.parametrize(
    ("speed", "n", "low", "high"),
    [(1.0, 2.0, 0, 90), (1.0, -2.0, 90, 180), (-1.0, -2.0, -180, -90), (-1.0, 2.0, -90, 0)],
)
def test_quadrants_of_table_2_1(speed: float, n: float, low: float, high: float) -> None:
    assert low < math.degrees(conversion.advance_angle(speed, n, 0.5)) < high


def test_efficiency_is_advance_power_over_shaft_power() -> None:
    n, D, rho = 3.0, 0.4, 1000.0
    speed, thrust, torque = np.array([0.3, 0.6]), np.array([40.0, 30.0]), np.array([3.0, 2.5])
    found = conversion.efficiency(
        conversion.advance_number(speed, n, D),
        conversion.thrust_coefficient(thrust, n, D, rho),
        conversion.torque_coefficient(torque, n, D, rho),
    )
    np.testing.assert_allclose(found, speed * thrust / conversion.power(n, torque), rtol=1e-14)


def test_refusals() -> None:
    with pytest.raises(InputError, match="shaft_speed: expected no 0 for a coefficient, found 0"):
        conversion.advance_number(1.0, [1.0, 0.0], 0.5)
    with pytest.raises(InputError, match=r"diameter: expected numbers above 0, found -0\.5"):
        conversion.thrust_coefficient(1.0, 1.0, -0.5, 1000.0)
    with pytest.raises(InputError, match="density: expected numbers above 0, found nan"):
        conversion.torque_coefficient(1.0, 1.0, 0.5, math.nan)
    with pytest.raises(InputError, match=r"advance_angle: expected a number within pi/2 of 0, found 2"):
        conversion.advance_number_of([0.1, 2.0])
    with pytest.raises(InputError, match="torque_coefficient: expected no 0 for an efficiency, found 0"):
        conversion.efficiency(0.1, 0.2, 0.0)
