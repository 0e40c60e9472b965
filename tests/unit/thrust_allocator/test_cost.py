"""Cost of thrust, [Ruth] 5.1 and App. D."""

from __future__ import annotations

import math

import daqp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import null_space
from scipy.optimize import minimize, minimize_scalar

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.thruster_configuration import cartesian_configuration, polar_configuration
from thrust_allocator.cost import (
    REGULARISATION,
    excess_bound,
    propeller_weights,
    quadratic_fit,
    regularised_cost,
    reweight,
    thrust_floor,
)

VESSEL = load_vessel("cybership3")
FLOOR = thrust_floor(VESSEL.thrust_min, VESSEL.thrust_max)
ONES = np.ones(4)


def weights_of(weight, before, floor, factor=None):
    out = np.empty(len(weight))
    reweight(weight, np.ones(len(weight)) if factor is None else factor, before, floor, out)
    return out


def test_example_5_1() -> None:
    k, p = quadratic_fit(1e3, 1e6)
    assert k == pytest.approx(1.94e-3, abs=0.005e-3)  # three digits are printed
    assert p == pytest.approx(0.94, abs=0.005)  # two digits
    thrust = np.geomspace(1e3, 1e6, 2001)
    error = np.abs(k * thrust**2 - thrust**1.5) / thrust**1.5
    assert error.max() == pytest.approx(p)
    # No other k has a smaller largest error.
    best = minimize_scalar(
        lambda c: np.abs(c * np.sqrt(thrust) - 1.0).max(), bounds=(1e-4, 1e-2), options={"xatol": 1e-12}
    )
    assert best.fun == pytest.approx(p, rel=1e-6)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-1.0, 1.0), (1.0, math.inf), (2.0, 1.0)])
def test_example_5_1_refuses(low: float, high: float) -> None:
    with pytest.raises(InputError, match="thrust_"):
        quadratic_fit(low, high)


def test_weights_from_propellers_have_mean_one_and_rank_power() -> None:
    weight = propeller_weights(VESSEL.propellers.power_per_thrust_3_2)
    assert weight.mean() == pytest.approx(1.0)
    # The same thrust costs in proportion to its power.
    power = VESSEL.propellers.power(np.full(4, 2.0))
    np.testing.assert_allclose(weight / weight[0], power / power[0], rtol=1e-12)


def test_weights_of_b_33_are_not_those_of_5_9() -> None:
    """(B.33) squared makes the tunnel thruster 50 times as dear as the aft ones; its power in Table 4.2 does not."""
    printed = np.array([6.62, 1.2, 0.90, 0.91]) ** 2
    printed /= printed.mean()
    np.testing.assert_allclose(printed, [3.74, 0.123, 0.069, 0.071], atol=0.005)
    ours = propeller_weights(VESSEL.propellers.power_per_thrust_3_2)
    np.testing.assert_allclose(ours, [1.247, 0.856, 0.959, 0.937], atol=5e-4)
    # From the full-scale figures of Table 4.2 alone, W and N, two digits of power.
    table = propeller_weights(np.array([0.031e6, 1.2e6, 2.6e6, 2.4e6]) / (np.array([16e3, 235e3, 365e3, 351e3]) ** 1.5))
    np.testing.assert_allclose(ours, table, rtol=0.05)


@pytest.mark.parametrize("value", [[], [[1.0]], [1.0, 0.0], [1.0, -2.0], [1.0, math.nan], [1.0, math.inf]])
def test_weights_from_propellers_refuse(value) -> None:
    with pytest.raises(InputError, match="power_per_thrust_3_2"):
        propeller_weights(value)


def test_by_hand() -> None:
    # (3^2 + 4^2)^(1/4) = sqrt 5; (0 + 16)^(1/4) = 2.
    out = weights_of(np.array([2.0, 3.0]), np.array([-3.0, 0.0]), np.array([4.0, 4.0]), np.array([1.0, 2.0]))
    np.testing.assert_allclose(out, [2.0 / math.sqrt(5.0), 3.0], rtol=1e-15)
    # 25^(3/4) = 5 sqrt 5, 16^(3/4) = 8.
    cost = regularised_cost(np.array([2.0, 3.0]), np.array([1.0, 2.0]), np.array([-3.0, 0.0]), np.array([4.0, 4.0]))
    assert cost == pytest.approx(4.0 / 3.0 * (2.0 * 5.0 * math.sqrt(5.0) + 48.0))


@given(before=st.floats(-20.0, 20.0), after=st.floats(-20.0, 20.0), floor=st.floats(1e-3, 1.0))
def test_the_weighted_square_is_an_upper_bound_that_touches(before: float, after: float, floor: float) -> None:
    one, e = np.ones(1), np.array([floor])
    weight = weights_of(one, np.array([before]), e)[0]
    at_before = regularised_cost(one, one, np.array([before]), e)
    at_after = regularised_cost(one, one, np.array([after]), e)
    assert at_after <= at_before + weight * (after**2 - before**2) + 1e-12 * (1.0 + at_before + at_after)


@given(thrust=st.floats(-20.0, 20.0), floor=st.floats(1e-6, 1.0))
def test_the_regularised_cost_is_near_that_of_the_power(thrust: float, floor: float) -> None:
    one, e = np.ones(1), np.array([floor])
    excess = regularised_cost(one, one, np.array([thrust]), e) - 4.0 / 3.0 * abs(thrust) ** 1.5
    rounding = 1e-13 * (abs(thrust) ** 1.5 + floor**1.5)
    assert -rounding <= excess <= excess_bound(one, one, e) + rounding
    # Marginal cost 2 w T against 2 sqrt T.
    if abs(thrust) > floor:
        marginal = weights_of(one, np.array([thrust]), e)[0] * abs(thrust)
        assert 1.0 - marginal / math.sqrt(abs(thrust)) <= floor**2 / (4.0 * thrust**2) + 1e-14


# App. D: two thrusters, one axis. Minimise |T1|^(3/2) + a |T2|^(3/2) with T1 + T2 = tau.


def two_thrusters(a: float, tau: float, start: tuple[float, float], floor: float, steps: int) -> list[float]:
    """T1 after every step, by (D.22) in the form without division by zero."""
    before = np.array(start)
    trace = []
    for _ in range(steps):
        w = weights_of(np.array([1.0, a]), before, np.full(2, floor))
        before = np.array([w[1], w[0]]) / w.sum() * tau
        trace.append(float(before[0]))
    return trace


@given(
    a=st.floats(0.2, 5.0),
    tau=st.one_of(st.floats(0.05, 1.0), st.floats(-1.0, -0.05)),
    start=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
)
def test_app_d_from_any_start(a: float, tau: float, start: tuple[float, float]) -> None:
    """Spans of 1 N, idle start included: monotone, to the closed form, within the samples of the derivation."""
    trace = two_thrusters(a, tau, start, REGULARISATION, 30)
    exact = a * a / (1.0 + a * a) * tau
    distance = [abs(value - exact) for value in trace]
    # The floor moves the optimum by the share e^2 / (4 T^2) of the marginal cost, and T by four times of that at most.
    smallest = abs(tau) / (1.0 + max(a, 1.0 / a) ** 2)
    offset = (REGULARISATION / smallest) ** 2 * abs(tau)
    assert distance[-1] <= offset + 1e-9
    for i in range(1, len(distance)):
        assert distance[i] <= distance[i - 1] + offset + 1e-12
    # Within 1 % of tau after log2(100 ln(r_0 / a^2)) steps, r_0 no farther than 1 / e; a quarter of the log-ratio is
    # the largest share of tau that it can mean, and one more for the offset.
    far = math.log(1.0 / REGULARISATION) + 2.0 * abs(math.log(a))
    samples = math.ceil(math.log2(25.0 * far)) + 1
    assert distance[samples] <= 0.01 * abs(tau) + offset


@given(a=st.floats(0.2, 5.0), ratio=st.floats(1e-3, 1e3), steps=st.integers(1, 12))
def test_app_d_halves_the_logarithm_of_the_ratio(a: float, ratio: float, steps: int) -> None:
    """r_k = a^2 (r_0 / a^2)^(2^-k), with a floor too small to matter."""
    start = (ratio / (1.0 + ratio), 1.0 / (1.0 + ratio))
    t1 = two_thrusters(a, 1.0, start, 1e-9, steps)[-1]
    expected = a * a * (ratio / (a * a)) ** (0.5**steps)
    assert t1 / (1.0 - t1) == pytest.approx(expected, rel=1e-9)  # 12 steps of rounding, and 1e-12 from the floor


# CyberShip III against direct minimisation.

WEIGHT = propeller_weights(VESSEL.propellers.power_per_thrust_3_2)
FIXED = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, VESSEL.fixed_direction)
FREE = np.hstack([FIXED[:, :1], cartesian_configuration(VESSEL.lever_x, VESSEL.lever_y)[:, [1, 2, 3, 5, 6, 7]]])
OWNER = [0, 1, 2, 3, 1, 2, 3]  # thruster of each column of FREE


def step_fixed(before: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """One step: minimise sum w T^2 with B T = tau, without limits."""
    inverse = FIXED.T / weights_of(WEIGHT, before, FLOOR)[:, None]
    return inverse @ np.linalg.solve(FIXED @ inverse, tau)


def sizes(z: np.ndarray) -> np.ndarray:
    return np.array([abs(z[0]), *(math.hypot(z[j], z[j + 3]) for j in (1, 2, 3))])


def step_free(before: np.ndarray, tau: np.ndarray) -> np.ndarray:
    inverse = FREE.T / weights_of(WEIGHT, sizes(before), FLOOR)[OWNER][:, None]
    return inverse @ np.linalg.solve(FREE @ inverse, tau)


def true_cost(thrust: np.ndarray) -> float:
    return 4.0 / 3.0 * float(WEIGHT @ np.abs(thrust) ** 1.5)


@given(tau=arrays(np.float64, 3, elements=st.floats(-3.0, 3.0)), start=arrays(np.float64, 4, elements=st.floats(-5, 5)))
def test_cybership_with_fixed_directions(tau: np.ndarray, start: np.ndarray) -> None:
    """Monotone descent from any start, to the optimum of the direct problem within the bound."""
    thrust = step_fixed(start, tau)
    cost = regularised_cost(WEIGHT, ONES, thrust, FLOOR)
    for _ in range(40):
        thrust = step_fixed(thrust, tau)
        after = regularised_cost(WEIGHT, ONES, thrust, FLOOR)
        assert after <= cost * (1.0 + 1e-12)
        cost = after
    # Four thrusters, three equations: one direction is left, and the direct problem is one of one variable.
    free = null_space(FIXED)[:, 0]
    origin = np.linalg.pinv(FIXED) @ tau
    direct = minimize_scalar(lambda s: true_cost(origin + s * free), bounds=(-50, 50), options={"xatol": 1e-10})
    bound = excess_bound(WEIGHT, ONES, FLOOR)
    assert direct.fun - 1e-9 <= true_cost(thrust) <= direct.fun + bound + 1e-9


@pytest.mark.parametrize("seed", range(8))
def test_cybership_with_rotating_thrusters(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tau = rng.normal(size=3) * (4.0, 4.0, 2.0)
    z = step_free(np.zeros(7), tau)
    cost = regularised_cost(WEIGHT, ONES, sizes(z), FLOOR)
    for _ in range(40):
        z = step_free(z, tau)
        after = regularised_cost(WEIGHT, ONES, sizes(z), FLOOR)
        assert after <= cost * (1.0 + 1e-12)
        cost = after
    free = null_space(FREE)
    origin = np.linalg.pinv(FREE) @ tau
    # Power is not smooth where a thruster rests: a simplex search has no derivative to trip over.
    direct = min(
        (
            minimize(
                lambda s: true_cost(sizes(origin + free @ s)),
                start,
                method="Nelder-Mead",
                options={"xatol": 1e-10, "fatol": 1e-13, "maxiter": 20000, "maxfev": 20000},
            )
            for start in (np.zeros(4), free.T @ (z - origin))
        ),
        key=lambda result: result.fun,
    )
    assert direct.fun - 1e-8 <= true_cost(sizes(z)) <= direct.fun + excess_bound(WEIGHT, ONES, FLOOR)


def test_an_idle_thruster_starts() -> None:
    tau = np.array([3.0, 1.0, 0.5])
    thrust = np.zeros(4)
    for _ in range(12):
        thrust = step_fixed(thrust, tau)
    np.testing.assert_allclose(FIXED @ thrust, tau, atol=1e-12)
    assert (np.abs(thrust) > 10.0 * FLOOR).all()


def test_a_dearer_thruster_gives_less() -> None:
    tau = np.array([3.0, 0.0, 0.0])
    answers = []
    for factor in (1.0, 4.0):
        thrust = np.zeros(4)
        factors = np.array([1.0, 1.0, factor, 1.0])
        for _ in range(40):
            inverse = FREE.T / weights_of(WEIGHT, thrust, FLOOR, factors)[OWNER][:, None]
            thrust = sizes(inverse @ np.linalg.solve(FREE @ inverse, tau))
        answers.append(thrust)
    assert answers[1][2] < 0.5 * answers[0][2]


SLACK = (1000.0 * np.array([1.0, 1.0, 10.0])) ** 2


def step_within_limits(before: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """One step with slack, magnitude and rate limits, by daqp."""
    step = VESSEL.thrust_rate * VESSEL.measurement.sample_time
    hessian = (FIXED.T * SLACK) @ FIXED + np.diag(weights_of(WEIGHT, before, FLOOR))
    upper = np.minimum(VESSEL.thrust_max, before + step)
    lower = np.maximum(VESSEL.thrust_min, before - step)
    answer, _, flag, _ = daqp.solve(
        hessian, -(FIXED.T * SLACK) @ tau, np.zeros((0, 4)), upper, lower, np.zeros(4, dtype=np.int32)
    )
    assert flag == 1
    return np.clip(answer, lower, upper)


@given(
    tau=arrays(np.float64, 3, elements=st.floats(-15.0, 15.0)),
    share=arrays(np.float64, 4, elements=st.floats(0.0, 1.0)),
)
def test_descent_with_slack_and_limits(tau: np.ndarray, share: np.ndarray) -> None:
    """F of the whole problem never rises, saturated and rate-limited steps included, and ends at its minimum."""

    def cost(thrust: np.ndarray) -> float:
        slack = tau - FIXED @ thrust
        return float(SLACK @ slack**2) + regularised_cost(WEIGHT, ONES, thrust, FLOOR)

    thrust = VESSEL.thrust_min + share * (VESSEL.thrust_max - VESSEL.thrust_min)
    for _ in range(60):
        before, thrust = thrust, step_within_limits(thrust, tau)
        # daqp solves a Hessian of condition 1e8 to about 1e-9 of the cost at the start of the step.
        assert cost(thrust) <= cost(before) * (1.0 + 1e-8) + 1e-9
    slack = tau - FIXED @ thrust
    gradient = -2.0 * FIXED.T @ (SLACK * slack) + 2.0 * weights_of(WEIGHT, thrust, FLOOR) * thrust
    span = VESSEL.thrust_max - VESSEL.thrust_min
    # Where a limit holds the thrust, the gradient points outwards; elsewhere it is zero, against 1e6 N of W_v per N.
    near = 1e-4 * (1.0 + np.abs(SLACK * slack).max() * 1e-3)
    assert (gradient[thrust < VESSEL.thrust_max - 1e-9 * span] >= -near).all()
    assert (gradient[thrust > VESSEL.thrust_min + 1e-9 * span] <= near).all()


def test_samples_to_one_percent_on_cybership() -> None:
    """[Ruth] 5.1 finds 5-10 samples typical. The local rate is 1/2, which is 7 from 100 % to 1 %."""
    rng = np.random.default_rng(1)
    for step in (step_fixed, step_free):
        size = 4 if step is step_fixed else 7
        samples = []
        for _ in range(200):
            tau = rng.normal(size=3) * (3.0, 3.0, 1.5)
            trace = [np.zeros(size)]
            for _ in range(60):
                trace.append(step(trace[-1], tau))
            far = [float(np.abs(z - trace[-1]).max() / np.abs(trace[-1]).max()) for z in trace]
            samples.append(max(i for i, d in enumerate(far) if d > 0.01) + 1)
        # Measured: 5 in the median and 7 at most, fixed and rotating.
        assert 4 <= np.median(samples) <= 6
        assert max(samples) <= 10
