"""Sensitivity functions: closed forms beside the equilibrium found by root finding, [Ruth] 3.5."""

from __future__ import annotations

import dataclasses
import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.propellers import BollardPropeller, WageningenBPropeller
from marine_model.propellers.zero_thrust import last_advance_number
from thruster_drivers.sensitivity import NominalCoefficients, Sensitivity, closed_form, nominal_coefficients
from thruster_drivers.sensitivity.numerical import Equilibrium, Operation, TorqueWeight

SEA = 1025.0
B4_70 = WageningenBPropeller(4.0, 4, 0.70, 0.58)
# Section 3.7.
WEIGHT = TorqueWeight(1.0, 0.5, 20.0)
ATTRIBUTES = tuple(field.name for field in dataclasses.fields(Sensitivity))
pitches = st.floats(0.5, 1.4)
shares = st.floats(0.0, 0.999)  # of the advance number at which thrust ends
thrusts = st.floats(1e3, 1e6)


def operation(desired_loading: float, thrust: float) -> Operation:
    """Return the operation at tau_d, by (2.31)."""
    return Operation(thrust, float(desired_loading) * math.sqrt(thrust / SEA) / B4_70.diameter, SEA)


def assert_equal(closed: Sensitivity, numerical: Sensitivity) -> None:
    for name in ATTRIBUTES:
        # brentq's 4 eps, times how much faster than n thrust falls near its end.
        assert float(getattr(closed, name)) == pytest.approx(float(getattr(numerical, name)), rel=1e-9, abs=1e-11), name


@pytest.mark.parametrize("law", ["shaft_speed", "torque", "power"])
@given(pitch=pitches, share=shares, thrust=thrusts)
def test_laws_of_fixed_pitch(law: str, pitch: float, share: float, thrust: float) -> None:
    J = share * float(last_advance_number(B4_70, pitch))
    closed = getattr(closed_form, law)(B4_70, J, pitch)
    found = getattr(Equilibrium(B4_70, pitch), law)(operation(closed.desired_loading, thrust))
    assert_equal(closed, found)


@given(share=shares, thrust=thrusts)
def test_laws_with_the_constants_of_1969(share: float, thrust: float) -> None:
    """K_Tc = 0.2394 and K_Qc = 0.0226 on a propeller with other coefficients: nothing is 1 at rest."""
    nominal = NominalCoefficients(0.2394, 0.0226)
    J = share * float(last_advance_number(B4_70, 0.58))
    for law in ("shaft_speed", "torque", "power"):
        closed = getattr(closed_form, law)(B4_70, J, 0.58, nominal)
        found = getattr(Equilibrium(B4_70, 0.58, nominal), law)(operation(closed.desired_loading, thrust))
        assert_equal(closed, found)


@given(pitch=pitches, share=shares, speed=st.floats(0.5, 4.0))
def test_pitch_control(pitch: float, share: float, speed: float) -> None:
    J = share * float(last_advance_number(B4_70, pitch))
    closed = closed_form.pitch(B4_70, J, pitch)
    thrust = float(B4_70.coefficients(0.0, pitch)[0]) * SEA * B4_70.diameter**4 * speed**2
    found = Equilibrium(B4_70).pitch(Operation(thrust, J * speed * B4_70.diameter, SEA), speed)
    assert_equal(closed, found)


@given(at_rest=st.floats(0.51, 1.2), share=st.floats(0.0, 1.0), thrust=thrusts)
def test_torque_shaft_speed_control(at_rest: float, share: float, thrust: float) -> None:
    nominal = nominal_coefficients(B4_70, at_rest)
    # Up to where the largest pitch has K_Qc no more.
    J = share * 0.99 * _saturation(nominal.torque)
    closed = closed_form.torque_shaft_speed(B4_70, J, nominal.torque)
    found = Equilibrium(B4_70, nominal=nominal).torque_shaft_speed(operation(closed.desired_loading, thrust))
    assert_equal(closed, found)


def _saturation(K_Qc: float) -> float:
    J = np.linspace(0.0, float(last_advance_number(B4_70, 1.4)), 2001)
    return float(J[B4_70.coefficients(J, 1.4)[1] >= K_Qc][-1])


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_combined_is_power_or_torque_control_at_the_ends(weight: float) -> None:
    J = np.linspace(0.0, 0.6, 13)
    law = closed_form.torque if weight else closed_form.power
    for name in ATTRIBUTES:
        # Exponents 1/2 and 3/6 are the same number, 1/3 and 2/6 too.
        np.testing.assert_array_equal(
            getattr(closed_form.combined(B4_70, J, weight), name), getattr(law(B4_70, J), name)
        )


def test_error_of_the_approximation_of_combined_control() -> None:
    """(3.46)-(3.54) beside the exact equilibrium with alpha(n): under 1 % in speed, 2.3 % in power on the B4-70.

    The figures are measured; the bounds are those with a digit to spare.
    """
    nominal = nominal_coefficients(B4_70)
    worst = dict.fromkeys(("shaft_speed", "thrust", "torque", "power"), 0.0)
    mixed = 0
    for desired in np.linspace(1.2, 2.4, 25):
        thrust = nominal.thrust * SEA * B4_70.diameter**4 * desired**2
        for V in np.linspace(0.0, 0.8, 17) * desired * B4_70.diameter:
            try:
                exact = Equilibrium(B4_70).combined(Operation(thrust, V, SEA), WEIGHT)
            except InputError:
                continue  # no thrust left
            alpha = WEIGHT(float(exact.shaft_speed) * desired)
            mixed += 0.1 < alpha < 0.9
            near = closed_form.combined(B4_70, exact.advance_number, alpha)
            for name in worst:
                ratio = float(getattr(near, name) / getattr(exact, name))
                worst[name] = max(worst[name], abs(ratio - 1.0))
    assert mixed > 20
    assert 0.005 < worst["shaft_speed"] < 0.01
    assert 0.01 < worst["thrust"] < 0.02
    assert 0.01 < worst["torque"] < 0.02
    assert 0.015 < worst["power"] < 0.03


@given(x=st.floats(0.9, 1.1), alpha=st.floats(0.0, 1.0))
def test_slope_of_the_approximation(x: float, alpha: float) -> None:
    """Near x = 1 the law x sn^3 = alpha sn + 1 - alpha has sn = x^(-1 / (3 - alpha)), not x^(-(2 + alpha) / 6)."""
    roots = np.roots([x, 0.0, -alpha, -(1.0 - alpha)])
    exact = max(root.real for root in roots if abs(root.imag) < 1e-9)
    # The remainder of a series to first order in x - 1.
    assert exact == pytest.approx(x ** (-1.0 / (3.0 - alpha)), abs=(x - 1.0) ** 2 + 1e-12)


@given(pitch=pitches, J=st.floats(0.0, 0.5), alpha=st.floats(0.0, 1.0))
def test_power_is_speed_times_torque_and_3_53_has_k_qc_above(pitch: float, J: float, alpha: float) -> None:
    found = closed_form.combined(B4_70, J, alpha, pitch)
    assert float(found.power) == pytest.approx(float(found.shaft_speed * found.torque), rel=1e-14)
    K_Qc, K_Q = (float(B4_70.coefficients(j, pitch)[1]) for j in (0.0, J))
    assert float(found.power) == pytest.approx((K_Qc / K_Q) ** (alpha / 2.0), rel=1e-12)  # (3.54)
    assert float(found.torque) == pytest.approx((K_Q / K_Qc) ** ((1.0 - alpha) / 3.0), rel=1e-12)  # (3.51)-(3.52)


def test_as_functions_of_tau_d() -> None:
    end = float(last_advance_number(B4_70, 0.58))
    tau_d = np.array([0.0, 0.5, 1.0, 2.0, 5.0])
    found = closed_form.at_desired_loading(lambda J: closed_form.torque(B4_70, J), tau_d, end)
    np.testing.assert_allclose(found.desired_loading[:4], tau_d[:4], rtol=1e-12, atol=1e-15)
    assert float(found.thrust[0]) == 1.0
    assert np.all(np.diff(found.thrust[:4]) < 0.0)
    # Beyond the end of the thrust there is nothing to tell.
    assert np.isnan(found.thrust[4])
    # Figure 3.10: torque control keeps thrust best, power control less, shaft-speed control least.
    at_one = [
        float(closed_form.at_desired_loading(lambda J, law=law: law(B4_70, J), 1.0, end).thrust)
        for law in (closed_form.torque, closed_form.power, closed_form.shaft_speed)
    ]
    assert at_one == sorted(at_one, reverse=True)


def test_no_pitch_beyond_saturation() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = closed_form.torque_shaft_speed(B4_70, np.array([0.0, 0.9, 1.48]), 0.0233)
    assert np.isnan(found.thrust).tolist() == [False, False, True]
    assert np.isnan(found.pitch_ratio).tolist() == [False, False, True]


def test_refusals() -> None:
    fixed = BollardPropeller(1.0, 1.0, 0.4, 0.05, -0.4, -0.03)
    at_rest = BollardPropeller(1.0, 1.0, 0.4, 0.05)
    with pytest.raises(InputError, match=r"expected one of controllable pitch"):
        closed_form.torque_shaft_speed(fixed, 0.1, 0.04)
    with pytest.raises(InputError, match=r"expected one of controllable pitch"):
        Equilibrium(fixed).torque_shaft_speed(Operation(100.0, 0.0, SEA))
    with pytest.raises(InputError, match=r"torque_coefficient: expected one .* at J = 0, found 0\.5"):
        closed_form.torque_shaft_speed(B4_70, 0.1, 0.5)
    with pytest.raises(InputError, match=r"weight: expected numbers from 0 to 1, found 1.5"):
        closed_form.combined(B4_70, 0.1, 1.5)
    with pytest.raises(InputError, match=r"advance_speed: expected 0 for a propeller known at zero advance alone"):
        Equilibrium(at_rest).torque(Operation(100.0, 0.1, SEA))
    with pytest.raises(InputError, match=r"no equilibrium in the range of the propeller at 9.0 m/s"):
        Equilibrium(fixed).torque(Operation(1.0, 9.0, SEA))
    with pytest.raises(InputError, match=r"no value from 0.5 to 1.4 gives K_Td"):
        Equilibrium(B4_70).pitch(Operation(1e9, 0.0, SEA), 1.0)
    with pytest.raises(InputError, match=r"thrust: expected a number above 0"):
        Operation(0.0, 0.0, SEA)
    with pytest.raises(InputError, match=r"advance_speed: expected at least 0, found -1.0"):
        Operation(1.0, -1.0, SEA)
    assert float(Equilibrium(at_rest).torque(Operation(100.0, 0.0, SEA)).thrust) == pytest.approx(1.0, rel=1e-14)
