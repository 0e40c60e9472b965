"""The problem as an object: its numbers, its forms, and closed-form answers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from thrust_allocator import AllocationProblem, Allocator, AllocatorSettings, Coupling, Phase, Weights, judge
from thrust_allocator.plan.polygon import rotating_rows

VESSEL = load_vessel("cybership3")
DT = 0.2
WEIGHTS = Weights.of(VESSEL)
ROOT = math.sqrt(0.5)


def plan(phase: Phase, lower: float, upper: float, azimuth: float, turn: float = 0.0) -> list[float]:
    return [phase, lower, upper, azimuth, -turn, turn]


def example(tau: tuple[float, float, float] = (1.0, -2.0, 0.5), coupling: Coupling | None = None) -> AllocationProblem:
    plans = [
        plan(Phase.FIXED, -0.1, 0.2, math.pi / 2),
        plan(Phase.LOST, 0.0, 0.0, 0.3),
        plan(Phase.ROTATING, 1.0, 3.0, 0.5, 0.2),
        plan(Phase.TURNING, -1.0, 2.0, -math.pi / 4),
    ]
    return AllocationProblem(WEIGHTS, np.array(plans), np.array(tau), coupling)


def test_weights_of_b34() -> None:
    np.testing.assert_allclose(WEIGHTS.slack, [1e6, 1e6, 1e8])  # (1000 * diag(1, 1, 10))^2
    np.testing.assert_allclose(WEIGHTS.thrust, [196.0, 1.44, 0.7225, 0.7569])  # diag(14, 1.2, 0.85, 0.87)^2
    assert WEIGHTS.zero_region == 0.001


def test_matrices_by_hand() -> None:
    problem = example()
    # Thruster 0 to starboard at 0.84 m; thruster 3 at -45 deg, arm -0.81 * -ROOT - 0.11 * ROOT = 0.70 * ROOT;
    # thruster 2 in Cartesian form, (4.24).
    B = np.array([[0.0, ROOT, 1.0, 0.0], [1.0, -ROOT, 0.0, 1.0], [0.84, 0.70 * ROOT, 0.11, -0.81]])
    np.testing.assert_allclose(problem.B, B, atol=1e-15)
    slack, thrust = np.diag([1e6, 1e6, 1e8]), np.diag([196.0, 0.7569, 0.7225, 0.7225])
    np.testing.assert_allclose(problem.H, B.T @ slack @ B + thrust, rtol=1e-14)
    np.testing.assert_allclose(problem.f, -B.T @ slack @ [1.0, -2.0, 0.5], rtol=1e-14)
    np.testing.assert_array_equal(problem.b_lower, [-0.1, -1.0] + [-np.inf] * 5)
    rows = np.array(rotating_rows(0.5, -0.2, 0.2, 1.0, 3.0, 0.001))
    np.testing.assert_array_equal(problem.b_upper, [0.2, 2.0, *rows[:, 2]])
    np.testing.assert_array_equal(problem.A, np.hstack([np.zeros((5, 2)), rows[:, :2]]))


def test_objective_is_half_the_cost() -> None:
    problem, z = example(), np.array([0.1, -0.4, 1.5, 0.7])
    slack = problem.tau - problem.B @ z
    cost = 1e6 * slack[0] ** 2 + 1e6 * slack[1] ** 2 + 1e8 * slack[2] ** 2
    cost += 196.0 * 0.1**2 + 0.7569 * 0.4**2 + 0.7225 * (1.5**2 + 0.7**2)
    assert 2.0 * problem.objective(z) == pytest.approx(cost, rel=1e-14)
    constant = 0.5 * (1e6 + 4e6 + 0.25e8)
    quadratic = 0.5 * z @ problem.H @ z + problem.f @ z + constant
    assert problem.objective(z) == pytest.approx(quadratic, rel=1e-12)


def test_slack_form_is_the_same_problem() -> None:
    problem, z = example(), np.array([0.1, -0.4, 1.5, 0.7])
    form = problem.slack_form()
    x = np.concatenate([z, problem.slack(z)])
    np.testing.assert_allclose(form.E @ x, form.tau, rtol=1e-12)
    np.testing.assert_allclose(np.diag(form.P)[4:], [100.0, 100.0, 1e4])
    assert form.scale == pytest.approx(1e-4)
    assert 0.5 * x @ form.P @ x == pytest.approx(form.scale * problem.objective(z), rel=1e-14)
    np.testing.assert_array_equal(form.G[:, :4], problem.A)
    np.testing.assert_array_equal(form.h, problem.b_upper[2:])
    np.testing.assert_array_equal(form.lower, [-0.1, -1.0] + [-np.inf] * 5)
    np.testing.assert_array_equal(form.upper, [0.2, 2.0] + [np.inf] * 5)


def test_shared_limits_are_rows_over_the_variables() -> None:
    a = np.arange(16.0).reshape(2, 4, 2)
    problem, plain = example(coupling=Coupling(a, np.array([5.0, 6.0]))), example()
    z = np.array([0.1, -0.4, 1.5, 0.7])
    np.testing.assert_array_equal(problem.A[:5], plain.A)
    np.testing.assert_allclose(problem.A[5:] @ z, (a * problem.forces(z)).sum(axis=(1, 2)), rtol=1e-14)
    np.testing.assert_array_equal(problem.b_upper[-2:], [5.0, 6.0])
    np.testing.assert_array_equal(problem.b_lower[-2:], [-np.inf, -np.inf])


def test_a_problem_keeps_its_numbers() -> None:
    allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"))
    allocator.step([3.0, 1.0, 0.5], DT)
    problem = allocator.problem
    assert problem is not None
    kept = problem.H.copy(), problem.f.copy(), problem.A.copy(), problem.b_upper.copy()
    allocator.step([-9.0, 9.0, 3.0], DT)
    for before, after in zip(kept, (problem.H, problem.f, problem.A, problem.b_upper), strict=True):
        np.testing.assert_array_equal(before, after)


def test_residuals_see_every_kind_of_fault() -> None:
    allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"))
    for _ in range(3):
        allocator.step([9.0, 9.0, 3.0], DT)
    problem, solution = allocator.problem, allocator.solution
    assert problem is not None
    assert solution is not None
    z, multipliers = solution.z, solution.multipliers
    assert max(judge(problem, z, multipliers)) < 1e-10
    at = problem.bounds + int(np.argmax(multipliers[problem.bounds :]))  # an active row
    assert multipliers[at] > 1e3
    outwards = problem.A[at - problem.bounds]
    assert judge(problem, z + 1e-3 * outwards, multipliers).violation == pytest.approx(1e-3, rel=1e-6)
    assert judge(problem, z - 1e-3 * outwards, multipliers).stationarity > 1e-4
    assert judge(problem, z - 1e-3 * outwards, multipliers).complementarity > 1e-6
    wrong = multipliers.copy()
    wrong[at] *= -1.0
    assert judge(problem, z, wrong).dual_violation > 1e-3
    for value in (np.nan, np.inf):
        spoiled = z.copy()
        spoiled[0] = value
        assert not judge(problem, spoiled, multipliers).within(1e9, 1e9)


def settled(mode: str, tau: list[float]) -> Allocator:
    allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode=mode))
    for _ in range(60):
        allocator.step(tau, DT)
    return allocator


def pseudo_inverse(B: np.ndarray, thrust_weight: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """W^-1 B' (B W^-1 B' + (gamma W_v)^-2)^-1 tau: the weighted pseudo-inverse, with the slack in it."""
    spread = B / thrust_weight
    return spread.T @ np.linalg.solve(spread @ B.T + np.diag(1.0 / WEIGHTS.slack), tau)


@pytest.mark.parametrize("tau", [[1.0, 0.0, 0.0], [0.0, -0.8, 0.0], [0.0, 0.0, 0.3], [0.5, 0.4, -0.2]])
def test_fixed_and_unsaturated_is_the_weighted_pseudo_inverse(tau: list[float]) -> None:
    allocator = settled("fixed", tau)
    result = allocator.step(tau, DT)
    assert not any(result.thrust_saturated)
    B = np.array([[0.0, 0.0, ROOT, ROOT], [1.0, 1.0, ROOT, -ROOT], [0.84, 0.76, -0.70 * ROOT, 0.70 * ROOT]])
    expected = pseudo_inverse(B, WEIGHTS.thrust, np.array(tau))
    # Condition of H 4e8 times rounding.
    np.testing.assert_allclose(result.thrust, expected, atol=1e-7)
    np.testing.assert_allclose(result.tau_achieved, tau, atol=1e-4)  # gamma = 1000 leaves 1e-6 of the demand or so


@pytest.mark.parametrize("tau", [[3.0, 0.5, 0.2], [2.0, 2.0, 0.5], [-3.0, 1.0, -0.4]])
def test_rotating_and_unsaturated_is_the_weighted_pseudo_inverse(tau: list[float]) -> None:
    allocator = settled("rotating", tau)
    result = allocator.step(tau, DT)
    assert not any(result.thrust_saturated)
    lx, ly = VESSEL.lever_x[1:], VESSEL.lever_y[1:]
    B = np.zeros((3, 7))
    B[:, 0] = [0.0, 1.0, 0.84]
    B[0, 1:4] = B[1, 4:] = 1.0
    B[2, 1:4], B[2, 4:] = -ly, lx
    weight = np.concatenate([WEIGHTS.thrust[:1], WEIGHTS.thrust[1:], WEIGHTS.thrust[1:]])
    expected = pseudo_inverse(B, weight, np.array(tau))
    force_x = result.thrust * np.cos(result.azimuth)
    force_y = result.thrust * np.sin(result.azimuth)
    np.testing.assert_allclose(force_y[0], expected[0], atol=1e-7)
    np.testing.assert_allclose(force_x[1:], expected[1:4], atol=1e-7)
    np.testing.assert_allclose(force_y[1:], expected[4:], atol=1e-7)


def test_surge_by_hand_on_two_thrusters() -> None:
    """Bow thrusters lost, rotating, pure surge: at the optimum both point ahead and balance each other's moment."""
    settings = AllocatorSettings(azimuth_mode="rotating", thruster_enabled=(False, False, True, True))
    allocator = Allocator(VESSEL, settings, azimuth=[0.0, 0.0, 0.3, -0.3])
    for _ in range(60):
        result = allocator.step([4.0, 0.0, 0.0], DT)
    assert result.phase == (Phase.LOST, Phase.LOST, Phase.ROTATING, Phase.ROTATING)
    # T_x each 2 N, T_y none: no yaw since the arms are -0.11 and 0.11 m. Slack and thrust weights share the rest:
    # 1e6 s = 2 N * 0.7397 (mean of 0.85^2 and 0.87^2) / 2 ... below 2e-6 N.
    np.testing.assert_allclose(result.thrust[2:], [2.0, 2.0], atol=2e-6)
    np.testing.assert_allclose(result.azimuth[2:], [0.0, 0.0], atol=1e-6)
    assert result.cost == pytest.approx(4.0 * (0.7225 + 0.7569), rel=1e-5)
