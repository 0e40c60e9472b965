"""Figures over seeds and what is said of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from dp_tools.campaign.over_seeds import Spread, Verdict, half_a_unit, over_seeds, verdicts
from dp_tools.figures import FigureSpec, Measurement
from dp_tools.figures.power import MeanPower
from marine_model.errors import InputError


def _spec(**fields: object) -> FigureSpec:
    return MeanPower.model_validate({"kind": "mean_power", "name": "p", "title": "P", "window": "w", **fields})


def _values(*values: float | None) -> list[Measurement]:
    return [Measurement(value) for value in values]


def test_mean_and_interval_by_hand() -> None:
    spread = over_seeds(_values(1.0, 2.0, 3.0))
    # Standard deviation 1, so the standard error is 1 / sqrt(3); with two degrees of freedom t is a closed form.
    half = 0.95 * math.sqrt(2.0 / (1.0 - 0.95**2)) / math.sqrt(3.0)
    assert spread.mean == 2.0
    assert spread.high == pytest.approx(2.0 + half, rel=1e-12)
    assert spread.low == pytest.approx(2.0 - half, rel=1e-12)
    assert (spread.least, spread.most, spread.seeds, spread.missing) == (1.0, 3.0, 3, 0)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=9))
def test_interval_is_that_of_scipy(values: list[float]) -> None:
    spread = over_seeds(_values(*values))
    assert spread.low is not None
    assert spread.high is not None
    if np.ptp(values) > 1e-6:  # scipy warns of identical values
        low, high = stats.t.interval(0.95, len(values) - 1, loc=np.mean(values), scale=stats.sem(values))
        assert (spread.low, spread.high) == pytest.approx((low, high), rel=1e-9, abs=1e-9)
    assert spread.low - 1e-9 <= np.mean(values) <= spread.high + 1e-9


def test_one_seed_has_the_interval_within_its_run() -> None:
    spread = over_seeds([Measurement(1.0, 0.9, 1.2)])
    assert (spread.mean, spread.low, spread.high) == (1.0, 0.9, 1.2)
    assert over_seeds([Measurement(1.0)]).low is None


def test_a_seed_without_a_value() -> None:
    spread = over_seeds(_values(1.0, None))
    assert (spread.mean, spread.low, spread.least, spread.most, spread.missing) == (None, None, 1.0, 1.0, 1)
    assert verdicts(_spec(at_most=5.0, thesis=1.0), spread) == (Verdict.FAILS, Verdict.DIFFERS)
    assert over_seeds(_values(None)) == Spread(None, None, None, None, None, 1, 1)


def test_no_seed_is_refused() -> None:
    with pytest.raises(InputError, match=r"seeds: expected at least one, found none"):
        over_seeds([])


@pytest.mark.parametrize(
    ("printed", "half"), [(-0.44, 0.005), (20.0, 0.5), (1.25, 0.005), (0.3, 0.05), (0.0, 0.5), (5e-05, 5e-6), (12, 0.5)]
)
def test_half_a_unit_of_the_last_digit(printed: float, half: float) -> None:
    assert half_a_unit(printed) == pytest.approx(half, rel=1e-12)


def test_a_printed_number_that_is_none() -> None:
    with pytest.raises(InputError, match=r"printed number: expected a finite one, found inf"):
        half_a_unit(math.inf)


def test_bounds_must_hold_in_every_seed() -> None:
    spread = over_seeds(_values(1.0, 2.0, 3.0))
    assert verdicts(_spec(at_most=3.0), spread) == (Verdict.HOLDS,)
    assert verdicts(_spec(at_most=2.9), spread) == (Verdict.FAILS,)  # though the mean is below
    assert verdicts(_spec(at_least=1.0), spread) == (Verdict.HOLDS,)
    assert verdicts(_spec(at_least=1.1, at_most=9.0), spread) == (Verdict.FAILS,)


def test_a_printed_number_must_lie_within_the_interval_or_half_a_unit_of_it() -> None:
    spread = Spread(-0.44, -0.45, -0.43, -0.46, -0.42, 5, 0)
    assert verdicts(_spec(thesis=-0.45), spread) == (Verdict.AGREES,)
    assert verdicts(_spec(thesis=-0.46), spread) == (Verdict.DIFFERS,)
    assert verdicts(_spec(thesis=-0.455), spread) == (Verdict.DIFFERS,)  # three digits: half a unit is 0.0005
    # -0.445 is printed as -0.44 or -0.45: both agree with a deterministic -0.445.
    still = Spread(-0.445, -0.445, -0.445, -0.445, -0.445, 5, 0)
    assert verdicts(_spec(thesis=-0.44), still) == verdicts(_spec(thesis=-0.45), still) == (Verdict.AGREES,)
    assert verdicts(_spec(thesis=-0.46), still) == (Verdict.DIFFERS,)
    assert verdicts(_spec(thesis=12.0), over_seeds(_values(12.4))) == (Verdict.AGREES,)
    assert verdicts(_spec(thesis=12.0), over_seeds(_values(12.6))) == (Verdict.DIFFERS,)


def test_bound_and_printed_number_each_have_their_verdict() -> None:
    spread = over_seeds(_values(1.0, 1.0))
    assert verdicts(_spec(thesis=1.0, at_most=2.0), spread) == (Verdict.HOLDS, Verdict.AGREES)
    assert verdicts(_spec(), spread) == (Verdict.SHOWN,)
