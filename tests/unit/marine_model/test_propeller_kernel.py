"""The compiled kernel against numpy, for every model; tangents outside the range; the load of a shaft."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from marine_model.propellers import BollardPropeller, PropellerModel
from marine_model.propellers.kernel import load, thrust_torque
from support.propellers import ALL, FIRST_QUADRANT

RHO = 1000.0
SPEED = st.one_of(st.just(0.0), st.floats(-30.0, 30.0))
ADVANCE = st.one_of(st.just(0.0), st.floats(-8.0, 8.0))
PITCH = st.floats(0.2, 2.0)
EVERY = pytest.mark.parametrize("model", ALL.values(), ids=ALL)
EVERY_FIRST_QUADRANT = pytest.mark.parametrize("model", FIRST_QUADRANT.values(), ids=FIRST_QUADRANT)


@EVERY
@given(n=SPEED, speed=ADVANCE, pitch=PITCH)
@settings(max_examples=300)
def test_kernel_and_numpy_agree(model: PropellerModel, n: float, speed: float, pitch: float) -> None:
    thrust, torque = (float(x) for x in model.forces(n, speed, RHO, pitch))
    found = thrust_torque(model.row(), model.diameter, RHO, n, speed, pitch)
    # Terms of the size of these cancel near K_T = 0.
    size = RHO * model.diameter**4 * (n * n + abs(n * speed) / model.diameter) + RHO * (model.diameter * speed) ** 2
    assert found[0] == pytest.approx(thrust, rel=1e-12, abs=1e-12 * size)
    assert found[1] == pytest.approx(torque, rel=1e-12, abs=1e-12 * size * model.diameter)


@EVERY
def test_zeros_behind_a_row_do_no_harm(model: PropellerModel) -> None:
    longer = np.concatenate([model.row(), np.zeros(500)])
    assert thrust_torque(longer, 0.2, RHO, 11.0, 0.5, 0.9) == thrust_torque(model.row(), 0.2, RHO, 11.0, 0.5, 0.9)


@EVERY
def test_forces_are_coefficients_within_the_range(model: PropellerModel) -> None:
    n, D = 9.0, model.diameter
    end = min(model.advance_number_range[1], 0.5)
    J = np.linspace(0.0, end, 7)
    K_T, K_Q = model.coefficients(J)
    thrust, torque = model.forces(n, J * n * D, RHO)
    # Tangent and back: a few roundings.
    np.testing.assert_allclose(thrust, K_T * RHO * D**4 * n * n, rtol=1e-12)
    np.testing.assert_allclose(torque, K_Q * RHO * D**5 * n * n, rtol=1e-12)


@EVERY_FIRST_QUADRANT
@given(n=SPEED, speed=ADVANCE)
def test_first_quadrant_models_are_odd(model: PropellerModel, n: float, speed: float) -> None:
    there = np.array(model.forces(n, speed, RHO))
    back = np.array(model.forces(-n, -speed, RHO))
    np.testing.assert_array_equal(there, -back)


@EVERY_FIRST_QUADRANT
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_tangents_go_on_outside(model: PropellerModel, side: float) -> None:
    """Below J = 0 and beyond the end thrust and torque coefficients are straight lines that touch the curve."""
    n, D = 10.0, model.diameter
    start = 0.0 if side < 0.0 else model.advance_number_range[1]
    step = 1e-4
    at = start + side * np.array([0.0, 1.0, 2.0, 3.0])
    inside = start - side * step
    for power, k in zip((4, 5), model.forces(n, at * n * D, RHO), strict=True):
        K = k / (RHO * D**power * n * n)
        np.testing.assert_allclose(np.diff(K, 2), 0.0, atol=1e-12)  # straight
        if model.advance_number_range[1] > 0.0:
            K_inside = float(model.forces(n, inside * n * D, RHO)[power - 4]) / (RHO * D**power * n * n)
            slope = (K[0] - K_inside) / step
            # A secant of 1e-4 against the tangent: off by half the step times a second derivative below 1.
            assert K[1] - K[0] == pytest.approx(slope, abs=1e-4)


@EVERY
@given(speed=ADVANCE, pitch=PITCH)
def test_finite_and_continuous_at_no_shaft_speed(model: PropellerModel, speed: float, pitch: float) -> None:
    row, D = model.row(), model.diameter
    at = np.array(thrust_torque(row, D, RHO, 0.0, speed, pitch))
    assert np.isfinite(at).all()
    for n in (1e-9, -1e-9, 5e-324):
        near = np.array(thrust_torque(row, D, RHO, n, speed, pitch))
        np.testing.assert_allclose(near, at, atol=1e-6)  # |n| V rho D^3 with n = 1e-9
    assert all(math.isfinite(x) for x in load(row, D, RHO, 0.0, speed, pitch))


def test_at_no_shaft_speed_a_linear_propeller_has_the_limit() -> None:
    """T = rho D^4 K_T0 n |n| + rho D^3 a_T |n| V_A: by hand 1000 * 0.2^3 * -0.4 * 0.5 * 2 = -3.2 N beside K_T0's."""
    model = BollardPropeller(0.2, 1.0, 0.4, 0.05, -0.4, -0.04)
    thrust, torque = thrust_torque(model.row(), 0.2, RHO, 0.5, 2.0, 1.0)
    assert thrust == pytest.approx(1000.0 * 0.0016 * 0.4 * 0.25 - 3.2, rel=1e-13)
    assert torque == pytest.approx(1000.0 * 0.00032 * 0.05 * 0.25 - 1000.0 * 0.0016 * 0.04 * 0.5 * 2.0, rel=1e-13)


@EVERY
@given(n=st.floats(0.5, 25.0), speed=st.floats(-4.0, 4.0), pitch=PITCH, sign=st.sampled_from([-1.0, 1.0]))
def test_the_load_is_a_tangent(model: PropellerModel, n: float, speed: float, pitch: float, sign: float) -> None:
    """Value and slope agree; what is left over a step h shrinks as h^2."""
    n *= sign
    row, D = model.row(), model.diameter
    c, a, b = load(row, D, RHO, n, speed, pitch)
    assert c > 0.0

    def left(h: float) -> float:
        m = n + h
        return c * m * abs(m) + a * abs(m) + b - thrust_torque(row, D, RHO, m, speed, pitch)[1]

    size = RHO * D**5 * (n * n + (speed / D) ** 2)
    assert abs(left(0.0)) < 1e-12 * size
    # The second derivative of Q over n is of size rho D^5; at a kink (end of a piece) slopes agree all the same.
    for h in (1e-2, -1e-2, 1e-3):
        assert abs(left(h)) < 20.0 * RHO * D**5 * (1.0 + (speed / (D * n)) ** 2) * h * h + 1e-12 * size


@pytest.mark.parametrize("name", ["bollard", "linear"])
@given(n=SPEED, speed=ADVANCE, other=SPEED)
def test_the_load_of_a_linear_model_is_exact(name: str, n: float, speed: float, other: float) -> None:
    model = ALL[name]
    c, a, b = load(model.row(), model.diameter, RHO, n, speed, 0.93)
    assert b == 0.0
    torque = thrust_torque(model.row(), model.diameter, RHO, other, speed, 0.93)[1]
    assert c * other * abs(other) + a * abs(other) == pytest.approx(torque, rel=1e-12, abs=1e-14)


@EVERY
def test_pitch_is_held_to_the_range(model: PropellerModel) -> None:
    low, high = model.pitch_range or (model.pitch_ratio, model.pitch_ratio)
    row = model.row()
    for beyond, limit in ((low - 0.3, low), (high + 0.3, high)):
        assert thrust_torque(row, 0.2, RHO, 5.0, 0.3, beyond) == thrust_torque(row, 0.2, RHO, 5.0, 0.3, limit)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.nan, 0.0, RHO), "shaft_speed: expected finite numbers, found nan"),
        ((1.0, np.inf, RHO), "advance_speed: expected finite numbers, found inf"),
        ((1.0, 0.0, 0.0), "density: expected a number above 0, found 0.0"),
        ((1.0, 0.0, RHO, np.nan), "pitch_ratio: expected finite numbers, found nan"),
    ],
)
def test_forces_refuse(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ALL["wageningen_b"].forces(*arguments)
