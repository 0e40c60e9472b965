"""Order statistics, against numpy and by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.statistics import quantile, summarize


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=50),
    st.floats(0.0, 1.0),
)
def test_quantile_is_numpys(values: list[float], share: float) -> None:
    # Interpolation rounds: a few units in the last place of the largest.
    assert quantile(values, share) == pytest.approx(np.quantile(values, share), rel=1e-9, abs=1e-9)


def test_summary_by_hand() -> None:
    summary = summarize([4.0, 1.0, 3.0, 2.0])
    assert (summary.count, summary.low, summary.median, summary.high) == (4, 1.0, 2.5, 4.0)
    assert summary.p99 == pytest.approx(3.0 + 0.97)  # at place 0.99 * 3 = 2.97


@pytest.mark.parametrize(
    ("values", "share", "message"),
    [
        ([], 0.5, "values: expected at least one, found none"),
        ([1.0, math.nan], 0.5, "values: expected finite numbers"),
        ([1.0], 1.5, "share: expected 0 to 1, found 1.5"),
    ],
)
def test_what_has_no_quantile_is_refused(values: list[float], share: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        quantile(values, share)
