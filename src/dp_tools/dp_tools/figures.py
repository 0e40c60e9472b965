"""Figures of merit: what a scenario asks for, worked out from a run, with confidence intervals."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dp_tools.figure_specs import (
    AzimuthStep,
    FigureSpec,
    ForceDeviation,
    ForceJump,
    ForceLevel,
    ForceTracking,
    MeanPower,
    MeanPowerChange,
    PositionError,
    ThrustLevel,
    ThrustLevelChange,
    TimeToDemand,
    VentilatingShare,
)
from dp_tools.interval import batch_jackknife
from dp_tools.limits import limits_violations
from dp_tools.run_data import RunData, Series
from dp_tools.scenario import Scenario
from dp_tools.signals import measured_force, position_error, total_power
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

_AXES = ("surge", "sway", "yaw")
_PLACES = ("north", "east", "heading")
_FORCE_UNITS = ("N", "N", "N m")
_PLACE_UNITS = ("m", "m", "deg")


@dataclass(frozen=True)
class Figure:
    """One figure of merit of one run.

    Parameters
    ----------
    spec
        What was asked for.
    value
        In ``unit``; None where the run never got there (a demand that is not reached).
    unit
        SI, degrees for angles, 1 for a ratio.
    low, high
        Ends of the 95 % confidence interval; None for extremes and counts, which one run gives no interval for.
    """

    spec: FigureSpec
    value: float | None
    unit: str
    low: float | None = None
    high: float | None = None

    @property
    def difference(self) -> float | None:
        """Ours minus the thesis's; None if either is missing."""
        if self.value is None or self.spec.thesis is None:
            return None
        return self.value - self.spec.thesis

    @property
    def held(self) -> bool | None:
        """Whether the bound that the scenario names holds; None if it names none."""
        if self.spec.at_most is None:
            return None
        return self.value is not None and self.value <= self.spec.at_most


def compute_figures(run: RunData, scenario: Scenario, vessel: Vessel) -> tuple[Figure, ...]:
    """Return the figures that ``scenario`` asks for, in its order.

    Raises
    ------
    InputError
        If a series or part of the run that a figure needs is missing.
    """
    return tuple(_compute(spec, run, scenario, vessel) for spec in scenario.figures)


def write_figures(path: Path, scenario: Scenario, figures: tuple[Figure, ...]) -> None:
    """Write figures.json."""
    entries = [
        {
            "name": figure.spec.name,
            "value": figure.value,
            "unit": figure.unit,
            "thesis": figure.spec.thesis,
            "low": figure.low,
            "high": figure.high,
        }
        for figure in figures
    ]
    document = {"run": scenario.run, "figures": entries}
    path.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _compute(spec: FigureSpec, run: RunData, scenario: Scenario, vessel: Vessel) -> Figure:
    if isinstance(spec, MeanPower):
        power = _column(total_power(run), scenario, spec.window, 0)
        return _with_interval(spec, "W", _mean, power)
    if isinstance(spec, MeanPowerChange):
        total = total_power(run)
        baseline = _column(total, scenario, spec.baseline, 0)
        compared = _column(total, scenario, spec.compared, 0)
        return _with_interval(spec, "1", _relative_change, baseline, compared)
    if isinstance(spec, PositionError):
        return _position_error(spec, run, scenario)
    if isinstance(spec, ForceLevel):
        axis = _AXES.index(spec.axis)
        series = measured_force(run, vessel) if spec.force == "tau_measured" else run[spec.force]
        force = _column(series, scenario, spec.window, axis)
        statistic = _mean if spec.statistic == "mean" else _std
        return _with_interval(spec, _FORCE_UNITS[axis], statistic, force)
    if isinstance(spec, ForceTracking):
        axis = _AXES.index(spec.axis)
        measured = measured_force(run, vessel)
        error = Series(measured.t, measured.values - run["tau_achieved"].at(measured.t))
        return _with_interval(spec, _FORCE_UNITS[axis], _rms, _column(error, scenario, spec.window, axis))
    if isinstance(spec, TimeToDemand):
        return Figure(spec, _longest_time_to_demand(spec, run, scenario), "s")
    if isinstance(spec, AzimuthStep):
        azimuth = run["azimuth_command"]
        if spec.window:
            azimuth = azimuth.window(*scenario.windows[spec.window])
        turn = wrap_angles(np.diff(azimuth.values, axis=0))
        return Figure(spec, math.degrees(float(np.abs(turn).max())), "deg")
    if isinstance(spec, ThrustLevel):
        return _with_interval(spec, "N", _mean, _thrust(spec.thruster, spec.window, run, scenario))
    if isinstance(spec, ThrustLevelChange):
        levels = [_thrust(spec.thruster, window, run, scenario) for window in (spec.baseline, spec.compared)]
        return _with_interval(spec, "1", _relative_change, *levels)
    if isinstance(spec, VentilatingShare):
        flags = _column(run["ventilating"], scenario, spec.window, run.thrusters.index(spec.thruster))
        return _with_interval(spec, "1", _mean, flags)
    if isinstance(spec, ForceDeviation | ForceJump):
        axis = _AXES.index(spec.axis)
        desired, achieved = (
            _column(run[name], scenario, spec.window, axis) for name in ("tau_desired", "tau_achieved")
        )
        deviation = np.abs(achieved - desired)
        if isinstance(spec, ForceJump):
            deviation = np.abs(np.diff(achieved)) - np.abs(np.diff(desired))
        return Figure(spec, float(deviation.max()), _FORCE_UNITS[axis])
    count = sum(check.violations for check in limits_violations(run, vessel))
    return Figure(spec, float(count), "1")


def _column(series: Series, scenario: Scenario, window: str, column: int) -> FloatArray:
    values = series.window(*scenario.windows[window]).values[:, column]
    return values[np.isfinite(values)]


def _thrust(thruster: str, window: str, run: RunData, scenario: Scenario) -> FloatArray:
    """Return the magnitude of the commanded thrust of one thruster over a window, N."""
    return np.abs(_column(run["thrust_command"], scenario, window, run.thrusters.index(thruster)))


def _with_interval(spec: FigureSpec, unit: str, statistic: Callable[..., float], *samples: FloatArray) -> Figure:
    low, high = batch_jackknife(statistic, samples)
    return Figure(spec, statistic(*samples), unit, low, high)


def _mean(x: FloatArray) -> float:
    return float(x.mean())


def _std(x: FloatArray) -> float:
    return float(x.std())


def _rms(x: FloatArray) -> float:
    return math.sqrt(float(np.mean(x * x)))


def _relative_change(baseline: FloatArray, compared: FloatArray) -> float:
    return float(compared.mean() / baseline.mean()) - 1.0


def _position_error(spec: PositionError, run: RunData, scenario: Scenario) -> Figure:
    axis = _PLACES.index(spec.axis)
    error = _column(position_error(run, f"{spec.of}_position"), scenario, spec.window, axis)
    unit = _PLACE_UNITS[axis]
    if unit == "deg":
        error = np.degrees(error)
    if spec.statistic == "max":
        return Figure(spec, float(np.abs(error).max()), unit)
    return _with_interval(spec, unit, _std if spec.statistic == "std" else _rms, error)


def times_to_demand(spec: TimeToDemand, run: RunData, scenario: Scenario) -> tuple[tuple[float, float | None], ...]:
    """Return (time of the step, time it took) of every joystick step in the window of ``spec``, s.

    The time it took is None where the commanded force was not within tolerance of the demand for good before the
    next step.
    """
    start, end = scenario.windows[spec.window]
    starts = [e.at for e in scenario.events if e.joystick is not None and start <= e.at < end]
    answers: list[tuple[float, float | None]] = []
    for at, until in zip(starts, [*starts[1:], end], strict=True):
        demand = run["tau_desired"].window(at, until)
        achieved = run["tau_achieved"].window(at, until)
        away = np.abs(achieved.values - demand.at(achieved.t)) > np.array(spec.tolerance)
        outside = np.flatnonzero(away.any(axis=1))
        if len(outside) == 0:
            answers.append((at, 0.0))
        elif outside[-1] + 1 == len(achieved.t):
            answers.append((at, None))
        else:
            answers.append((at, round(float(achieved.t[outside[-1] + 1]) - at, 9)))  # stamps are whole ns
    return tuple(answers)


def _longest_time_to_demand(spec: TimeToDemand, run: RunData, scenario: Scenario) -> float | None:
    times = [took for _, took in times_to_demand(spec, run, scenario)]
    if not times or any(took is None for took in times):
        return None
    return max(took for took in times if took is not None)
