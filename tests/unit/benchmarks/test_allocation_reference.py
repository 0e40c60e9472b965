"""The reference optimum: closed forms, and the conditions of an optimum."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import benchmarks.reference
from benchmarks.demands import demand_in_waves, record
from benchmarks.reference import Batch, optima, optimum
from marine_model import load_vessel
from thrust_allocator import AllocatorSettings
from thrust_allocator.plan.phase import Phase, Plan
from thrust_allocator.program.problem import AllocationProblem, Weights

VESSEL = load_vessel("cybership3")


def _steps(mode: str, count: int = 60) -> list[AllocationProblem]:
    # At this size most steps have active limits, also of several thrusters.
    demands = 2.5 * demand_in_waves(VESSEL, count, 5)
    return [step.problem for step in record(VESSEL, AllocatorSettings(azimuth_mode=mode), demands, 0.2)]


@given(st.floats(-5.0, 5.0), st.floats(-5.0, 0.0), st.floats(0.1, 5.0))
@settings(deadline=None)
def test_one_thruster_is_a_clipped_quotient(force: float, lower: float, upper: float) -> None:
    plans = np.zeros((4, Plan.COLUMNS))  # all lost but one
    plans[1] = Phase.FIXED, lower, upper, 0.3, 0.0, 0.0
    problem = AllocationProblem(Weights.of(VESSEL), plans, np.array([force, 0.5, -0.2]))
    found = optimum(Batch.of([problem]))
    expected = min(max(-problem.f[0] / problem.H[0, 0], lower), upper)
    assert found.verified.all()
    # The quotient itself has 53 bits only.
    assert float(found.z[0, 0]) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_no_point_on_the_way_to_another_feasible_one_is_cheaper(mode: str) -> None:
    batch = Batch.of(_steps(mode))
    found = optimum(batch)
    assert found.verified.all()
    assert batch.violation(found.z).max() <= 1e-12
    draw = np.random.default_rng(6)
    for _ in range(10):
        # What is best for another demand is feasible here too, and mostly somewhere else on the limits.
        tau = draw.normal(scale=[20.0, 20.0, 10.0], size=batch.tau.shape)
        elsewhere = replace(batch, tau=tau, f=-np.einsum("nij,ni->nj", batch.B, batch.V * tau))
        other = optimum(elsewhere).z
        assert np.abs(other - found.z).max() > 0.1
        for part in (1e-4, 1e-2, 1.0):
            assert np.all(batch.cost(found.z + part * (other - found.z)) >= found.cost * (1.0 - 1e-14))


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_a_wrong_active_set_is_mended(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    batch = Batch.of(_steps(mode))
    right = optimum(batch)
    monkeypatch.setattr(
        benchmarks.reference, "_active_by_daqp", lambda batch: np.zeros(batch.upper.shape, dtype=np.int8)
    )
    mended = optimum(batch)
    good = mended.verified
    # Exchanging one limit after another may cycle; where it ends it ends at the optimum.
    assert good.mean() > 0.8
    assert np.allclose((mended.cost[good] / right.cost[good]).astype(float), 1.0, rtol=1e-14)


def test_a_wrong_answer_is_not_verified(monkeypatch: pytest.MonkeyPatch) -> None:
    batch = Batch.of(_steps("rotating"))
    solve = benchmarks.reference._solve

    def spoiled(batch, active, of):
        z, multipliers = solve(batch, active, of)
        return z + 1e-6, multipliers

    monkeypatch.setattr(benchmarks.reference, "_solve", spoiled)
    assert not optimum(batch).verified.any()
    with pytest.raises(ValueError, match=r"reference: 60 of 60 problems not solved"):
        optima(_steps("rotating"))


def test_forms_do_not_mix() -> None:
    with pytest.raises(ValueError, match="problems: expected one form"):
        Batch.of([*_steps("fixed", 1), *_steps("rotating", 1)])
