"""Guards at the door of every core."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from marine_model.errors import DocumentError, DpError, InputError, UnknownNameError
from marine_model.guards import finite_number, finite_vector, positive_number


@pytest.mark.parametrize("value", [[1, 2.5, -3], (1.0, 2.5, -3.0), np.array([1.0, 2.5, -3.0])])
def test_vectors_become_float64(value: Any) -> None:
    vector = finite_vector("tau", value, 3)
    assert vector.dtype == np.float64
    np.testing.assert_array_equal(vector, [1.0, 2.5, -3.0])


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1.0, 2.0], "tau: expected shape (3,), found (2,)"),
        (1.0, "tau: expected shape (3,), found ()"),
        ([[1.0], [2.0], [3.0]], "tau: expected shape (3,), found (3, 1)"),
        ([1.0, math.nan, 3.0], "tau: expected finite numbers, found [1.0, nan, 3.0]"),
        ([1.0, 2.0, -math.inf], "tau: expected finite numbers, found [1.0, 2.0, -inf]"),
        ([1.0, "a", 3.0], "tau: expected 3 numbers, found [1.0, 'a', 3.0]"),
        ([1.0, None, [2]], "tau: expected 3 numbers, found [1.0, None, [2]]"),
        ([1.0, 1j, 2.0], "tau: expected 3 numbers, found [1.0, 1j, 2.0]"),
        ([1.0, 10**400, 2.0], "tau: expected 3 numbers, found [1.0, 1000"),
        ({"x": 1.0}, "tau: expected 3 numbers, found {'x': 1.0}"),
    ],
)
def test_vectors_that_are_refused(value: Any, message: str) -> None:
    with pytest.raises(InputError) as caught:
        finite_vector("tau", value, 3)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (math.nan, "dt: expected a finite number, found nan"),
        (math.inf, "dt: expected a finite number, found inf"),
        (None, "dt: expected a number, found None"),
        ([1.0], "dt: expected a number, found [1.0]"),
        (10**400, "dt: expected a number, found 1000"),
    ],
)
def test_numbers_that_are_refused(value: Any, message: str) -> None:
    for guard in (finite_number, positive_number):
        with pytest.raises(InputError) as caught:
            guard("dt", value)
        assert str(caught.value).startswith(message)


def test_positive_means_above_zero() -> None:
    assert positive_number("dt", 1e-300) == 1e-300
    for value in (0.0, -0.0, -1.0):
        with pytest.raises(InputError, match=r"dt: expected a number above 0, found -?[01]\.0"):
            positive_number("dt", value)


def test_one_clause_catches_all_errors_of_the_project() -> None:
    for kind in (InputError, DocumentError, UnknownNameError):
        assert issubclass(kind, DpError)
        assert issubclass(kind, ValueError)
