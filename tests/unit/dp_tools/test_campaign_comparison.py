"""Differences between runs, and the fingerprint that says that there are none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from dp_tools.campaign.comparison import differences, largest
from dp_tools.campaign.fingerprint import fingerprint
from dp_tools.run_data import Labels, RunData, Series
from marine_model import load_vessel
from support.synthetic_run import synthetic_run


@pytest.fixture(scope="module")
def run() -> RunData:
    return synthetic_run(load_vessel("cybership3"), duration=10.0)


def _with(run: RunData, name: str, series: Series | None) -> RunData:
    kept = {key: value for key, value in run.series.items() if key != name}
    return replace(run, series=kept if series is None else kept | {name: series})


def _changed(run: RunData, name: str, row: int, column: int, value: float) -> RunData:
    values = run[name].values.copy()
    values[row, column] = value
    return _with(run, name, Series(run[name].t, values))


def test_the_same_run_is_not_apart(run: RunData) -> None:
    found = differences(run, run)
    assert set(found.values()) == {0.0}
    assert len(found) == 2 * len(run.series) + len(run.labels)
    assert largest(found) == ("", 0.0)


def test_the_largest_difference_is_named(run: RunData) -> None:
    other = _changed(_changed(run, "pose", 3, 1, run["pose"].values[3, 1] + 1e-6), "tau_desired", 0, 0, 99.0)
    found = differences(run, other)
    assert found["pose"] == pytest.approx(1e-6, rel=1e-6)
    assert largest(found)[0] == "tau_desired"
    assert differences(other, run) == found


def test_what_is_missing_in_both_is_the_same(run: RunData) -> None:
    lost = _changed(run, "pose", 3, 1, math.nan)
    assert differences(lost, lost)["pose"] == 0.0
    assert differences(lost, run)["pose"] == math.inf
    forever = _changed(run, "allocation_cost", 0, 0, math.inf)
    assert differences(forever, forever)["allocation_cost"] == 0.0


def test_a_series_or_row_or_word_in_one_run_only(run: RunData) -> None:
    assert differences(run, _with(run, "truth_thrust", None))["truth_thrust"] == math.inf
    shorter = _with(run, "power", Series(run["power"].t[:-1], run["power"].values[:-1]))
    assert differences(run, shorter)["power"] == math.inf
    words = replace(run, labels={**run.labels, "azimuth_mode": Labels(np.array([0.0]), ("auto",))})
    assert differences(run, words)["azimuth_mode words"] == math.inf
    assert differences(run, replace(run, labels={}))["controller_mode words"] == math.inf


def test_times_count(run: RunData) -> None:
    later = _with(run, "power", Series(run["power"].t + 1e-3, run["power"].values))
    assert differences(run, later)["power time"] == pytest.approx(1e-3)


def test_equal_runs_have_one_fingerprint(run: RunData) -> None:
    again = synthetic_run(load_vessel("cybership3"), duration=10.0)
    assert fingerprint(run) == fingerprint(again)
    # It does not matter in which order the series are kept, nor the sign of a zero.
    turned = replace(run, series=dict(reversed(list(run.series.items()))))
    assert fingerprint(turned) == fingerprint(run)
    assert fingerprint(_changed(run, "joystick", 0, 0, -0.0)) == fingerprint(run)


def test_any_change_changes_the_fingerprint(run: RunData) -> None:
    value = run["pose"].values[3, 1]
    others = [
        _changed(run, "pose", 3, 1, np.nextafter(value, 1.0)),
        _changed(run, "pose", 3, 1, math.nan),
        _with(run, "pose", None),
        _with(run, "power", Series(np.nextafter(run["power"].t, 99.0), run["power"].values)),
        replace(run, labels={**run.labels, "azimuth_mode": Labels(np.array([0.0]), ("auto",))}),
        replace(run, labels={**run.labels, "azimuth_mode": Labels(np.array([0.2]), ("fixed",))}),
    ]
    found = [fingerprint(run), *map(fingerprint, others)]
    assert len(set(found)) == len(found)
