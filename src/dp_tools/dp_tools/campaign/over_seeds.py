"""A figure of merit over several seeds: mean, confidence interval, extremes, and what to say of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum

import numpy as np

from dp_tools.figures import FigureSpec, Measurement
from dp_tools.interval import CONFIDENCE
from marine_model.errors import InputError


class Verdict(StrEnum):
    """What to say of a figure."""

    HOLDS = "holds"  # every bound, in every seed
    FAILS = "fails"  # a bound is broken, or the run never got there, in at least one seed
    AGREES = "agrees"  # the printed number lies within the interval
    DIFFERS = "differs"  # it does not
    SHOWN = "shown"  # nothing to hold it against


@dataclass(frozen=True)
class Spread:
    """One figure over seeds.

    Attributes
    ----------
    mean
        Mean over the seeds; None if a seed has no value.
    low, high
        95 % confidence interval: over the seeds by Student's t; of one seed, that within its run, None where there is
        none.
    least, most
        Extremes over the seeds; None without any value.
    seeds
        Number of seeds.
    missing
        Number of those without a value.
    """

    mean: float | None
    low: float | None
    high: float | None
    least: float | None
    most: float | None
    seeds: int
    missing: int


def over_seeds(values: Sequence[Measurement]) -> Spread:
    """Return one figure over seeds. Raises InputError without any seed."""
    if not values:
        raise InputError("seeds: expected at least one, found none")
    known = np.array([one.value for one in values if one.value is not None])
    count, missing = len(values), len(values) - len(known)
    least, most = (float(known.min()), float(known.max())) if len(known) else (None, None)
    if missing:
        return Spread(None, None, None, least, most, count, missing)
    mean = float(known.mean())
    if count == 1:
        return Spread(mean, values[0].low, values[0].high, least, most, count, missing)
    from scipy.special import stdtrit  # here: its import is slow

    error = float(known.std(ddof=1)) / math.sqrt(count)
    half = float(stdtrit(count - 1, 0.5 + 0.5 * CONFIDENCE)) * error
    return Spread(mean, mean - half, mean + half, least, most, count, missing)


def half_a_unit(printed: float) -> float:
    """Return half a unit of the last digit of a number as it is written: 0.005 for -0.44, 0.5 for 20.0.

    A zero at the end of a decimal cannot be seen in a number: 1.20 counts as 1.2.
    """
    exponent = Decimal(repr(printed)).as_tuple().exponent
    if not isinstance(exponent, int):
        raise InputError(f"printed number: expected a finite one, found {printed}")
    if printed == math.trunc(printed):
        return 0.5
    return 0.5 * 10.0**exponent


def verdicts(spec: FigureSpec, spread: Spread) -> tuple[Verdict, ...]:
    """Return what is to be said of a figure: of its bounds, of its printed number, or that it is shown.

    Bounds must hold in every seed. A printed number must lie within the interval, or within half a unit of its last
    digit of it; without an interval (an extreme of one seed), of the value.
    """
    found = []
    if spec.at_most is not None or spec.at_least is not None:
        found.append(Verdict.HOLDS if _holds(spec, spread) else Verdict.FAILS)
    if spec.thesis is not None:
        found.append(Verdict.AGREES if _agrees(spec.thesis, spread) else Verdict.DIFFERS)
    return tuple(found) or (Verdict.SHOWN,)


def _holds(spec: FigureSpec, spread: Spread) -> bool:
    if spread.missing or spread.least is None or spread.most is None:
        return False
    above = spec.at_least is None or spread.least >= spec.at_least
    return above and (spec.at_most is None or spread.most <= spec.at_most)


def _agrees(printed: float, spread: Spread) -> bool:
    if spread.mean is None:
        return False
    low = spread.mean if spread.low is None else spread.low
    high = spread.mean if spread.high is None else spread.high
    # Decimals are not exact: 0.445 - 0.44 is a little more than 0.005.
    margin = half_a_unit(printed) * (1.0 + 1e-9)
    return low - margin <= printed <= high + margin
