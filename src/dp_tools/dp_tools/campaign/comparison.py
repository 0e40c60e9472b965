"""How far two runs of one scenario are apart, series by series."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from dp_tools.run_data import RunData
from marine_model.guards import FloatArray

# The aim for graph against in process, in the unit of each series (m, rad, N, W ...).
AGREEMENT = 1e-9


def differences(first: RunData, second: RunData) -> dict[str, float]:
    """Return the largest difference by series, of its times (``pose time``) and of its words (``azimuth_mode words``).

    A value that is missing in both (NaN) is the same. Infinite where a series is in one run only, has another number
    of rows, or a value is missing in one of them; a word is the same or infinitely apart.
    """
    found: dict[str, float] = {}
    for name in sorted(set(first.series) | set(second.series)):
        if name not in first.series or name not in second.series:
            found[name] = math.inf
            continue
        one, other = first.series[name], second.series[name]
        found[name] = _apart(one.values, other.values)
        found[f"{name} time"] = _apart(one.t, other.t)
    for name in sorted(set(first.labels) | set(second.labels)):
        one_word, other_word = first.labels.get(name), second.labels.get(name)
        same = one_word is not None and other_word is not None and one_word.words == other_word.words
        if same and one_word is not None and other_word is not None:
            found[f"{name} words"] = _apart(one_word.t, other_word.t)
        else:
            found[f"{name} words"] = math.inf
    return found


def largest(found: Mapping[str, float]) -> tuple[str, float]:
    """Return the name and size of the largest difference; an empty name if there is none at all."""
    name = max(found, key=lambda name: found[name], default="")
    return (name, found[name]) if name and found[name] > 0.0 else ("", 0.0)


def _apart(one: FloatArray, other: FloatArray) -> float:
    if one.shape != other.shape:
        return math.inf
    missing = np.isnan(one)
    if (missing != np.isnan(other)).any():
        return math.inf
    with np.errstate(invalid="ignore"):  # infinite in both: no difference
        apart = np.where(missing | (one == other), 0.0, np.abs(one - other))
    return float(apart.max(initial=0.0))
