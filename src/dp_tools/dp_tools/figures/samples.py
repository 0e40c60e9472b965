"""Samples of a window, and statistics of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

from dp_tools.run_data import Series
from marine_model.axes import AXES as SIX
from marine_model.axes import FORCE_UNITS, HORIZONTAL, VERTICAL, Axis
from marine_model.guards import FloatArray

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

PlaneAxis = Literal["surge", "sway", "yaw"]
# Heave, roll and pitch of a submerged vehicle are in series of their own.
_BELOW = {
    "tau_desired": "vertical_desired",
    "tau_achieved": "vertical_achieved",
    "estimate_position": "vertical_estimate",
    "truth_position": "vertical_truth",
}


def axis_unit(axis: Axis) -> str:
    """Return the unit of a force along, or a moment about, an axis."""
    return FORCE_UNITS[SIX.index(axis)]


def series_of_axis(name: str, axis: Axis) -> tuple[str, int]:
    """Return the series in which ``axis`` of ``name`` stands, and its column."""
    if axis in HORIZONTAL:
        return name, HORIZONTAL.index(axis)
    return _BELOW[name], VERTICAL.index(axis)


def column(series: Series, scenario: Scenario, window: str | tuple[str, ...], index: int) -> FloatArray:
    """Return the finite samples of one column over a window, or over several one after another."""
    names = (window,) if isinstance(window, str) else window
    values: FloatArray = np.concatenate([series.window(*scenario.windows[name]).values[:, index] for name in names])
    return values[np.isfinite(values)]


def mean(x: FloatArray) -> float:
    """Return the mean."""
    return float(x.mean())


def std(x: FloatArray) -> float:
    """Return the standard deviation."""
    return float(x.std())


def rms(x: FloatArray) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(x * x)))


def relative_change_of(statistic: Callable[[FloatArray], float]) -> Callable[[FloatArray, FloatArray], float]:
    """Return the function (baseline, compared) -> statistic of ``compared`` over that of ``baseline``, minus one."""

    def change(baseline: FloatArray, compared: FloatArray) -> float:
        return statistic(compared) / statistic(baseline) - 1.0

    return change


relative_change = relative_change_of(mean)
