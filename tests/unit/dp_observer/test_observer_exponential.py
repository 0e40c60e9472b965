"""The matrix exponential applied to a vector, against SciPy's matrix exponential."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from dp_observer.exponential import LinearFlow, growth_rate, taylor_terms
from marine_model.guards import FloatArray


def by_augmentation(a: FloatArray, x: FloatArray, force: FloatArray, ramp: FloatArray, t: float) -> FloatArray:
    """x(t) from one exponential of the system with the input as extra states (Van Loan)."""
    n = len(x)
    big = np.zeros((n + 2, n + 2))
    big[:n, :n] = a
    big[:n, n], big[:n, n + 1] = ramp, force
    big[n, n + 1] = 1.0  # the extra states are time and the number one
    state = np.concatenate([x, [0.0, 1.0]])
    return np.asarray((expm(big * t) @ state)[:n])


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 15),
    size=st.floats(1e-3, 30.0),
    t=st.floats(1e-3, 1.0),
)
@settings(max_examples=200, deadline=None)
def test_equals_the_matrix_exponential(seed: int, n: int, size: float, t: float) -> None:
    random = np.random.default_rng(seed)
    a = random.standard_normal((n, n)) * size / np.sqrt(n)
    x, force, ramp = random.standard_normal((3, n))
    flow = LinearFlow(n, growth_rate(a[np.newaxis]))
    expected = by_augmentation(a, x, force, ramp, t)
    # Rounding grows with the largest intermediate value, exp(|A| t); both sides have it.
    scale = np.exp(np.linalg.norm(a, 2) * t) * (1.0 + t) ** 2 * np.sqrt(n) * 10
    np.testing.assert_allclose(flow.advance(a, x, force, ramp, t), expected, atol=1e-14 * scale, rtol=1e-11)


def test_no_ramp_is_a_ramp_of_zero() -> None:
    random = np.random.default_rng(3)
    a = random.standard_normal((5, 5))
    x, force = random.standard_normal((2, 5))
    flow = LinearFlow(5, growth_rate(a[np.newaxis]))
    with_zero = flow.advance(a, x, force, np.zeros(5), 1.0)
    np.testing.assert_allclose(flow.advance(a, x, force, None, 1.0), with_zero, rtol=1e-14)


def test_arguments_are_not_changed() -> None:
    a, x, force, ramp = -np.eye(3), np.ones(3), np.ones(3), np.ones(3)
    LinearFlow(3, 1.0).advance(a, x, force, ramp, 0.5)
    for vector in (x, force, ramp):
        assert (vector == 1.0).all()
    assert (a == -np.eye(3)).all()


@pytest.mark.parametrize("growth", [0.0, 0.1, 1.0, 2.4, 4.0])
def test_terms_suffice(growth: float) -> None:
    count = taylor_terms(growth)
    term, total = 1.0, 1.0
    for j in range(1, count + 1):
        term *= growth / j
        total += term
    assert total == pytest.approx(np.exp(growth), rel=1e-15)


def test_growth_rate_bounds_late_terms() -> None:
    """For a matrix far from normal the rate is far below the norm, and still bounds every late power."""
    a = np.array([[-1.0, 100.0], [0.0, -1.0]])
    rate = growth_rate(a[np.newaxis])
    assert rate < 0.1 * np.linalg.norm(a, 2)
    for j in range(20, 60):
        assert np.linalg.norm(np.linalg.matrix_power(a, j), 2) <= rate**j * (1 + 1e-12)
