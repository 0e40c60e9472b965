"""Samples of a window, and statistics of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

from dp_tools.run_data import Series
from marine_model.guards import FloatArray

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Axis = Literal["surge", "sway", "yaw"]
AXES: tuple[Axis, ...] = ("surge", "sway", "yaw")
FORCE_UNITS = ("N", "N", "N m")


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
