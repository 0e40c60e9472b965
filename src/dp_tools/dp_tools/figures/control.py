"""Figures of the terms of the controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import AXES, FORCE_UNITS, Axis, column, relative_change_of, rms
from dp_tools.run_data import RunData
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Term = Literal["proportional", "integral", "derivative"]


class ControlTermLevel(WindowFigure):
    """Root mean square or largest magnitude of a term of the controller over a window, N or N m."""

    kind: Literal["control_term_level"]
    term: Term
    axis: Axis
    statistic: Literal["rms", "max"]

    @property
    def unit(self) -> str:
        """Newton or newton metre."""
        return FORCE_UNITS[AXES.index(self.axis)]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        values = column(run[self.term], scenario, self.window, AXES.index(self.axis))
        return Measurement(float(np.abs(values).max())) if self.statistic == "max" else Measurement.of(rms, values)


class ControlTermChange(ComparedFigure):
    """That of one window over that of another, minus one; "max" is the mean of the largest of each window."""

    kind: Literal["control_term_change"]
    term: Term
    axis: Axis
    statistic: Literal["rms", "max"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        index = AXES.index(self.axis)
        sides = (self.baseline, self.compared)
        if self.statistic == "rms":
            values = [column(run[self.term], scenario, windows, index) for windows in sides]
            return Measurement.of(relative_change_of(rms), *values)
        off, on = (
            np.mean([np.abs(column(run[self.term], scenario, window, index)).max() for window in windows])
            for windows in sides
        )
        return Measurement(float(on / off) - 1.0)


class IntegralLag(WindowFigure):
    """Time by which the integral term changes sign after the proportional one, s.

    Looked at is the largest excursion of the proportional term in the window: when it began, and when the integral term
    came to the same side. 0 if it was there already.
    """

    kind: Literal["integral_lag"]
    axis: Axis

    @property
    def unit(self) -> str:
        """Second."""
        return "s"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the time; None if the integral term did not change sign within the window."""
        return Measurement(_lag(run, scenario, self.window, AXES.index(self.axis)))


class IntegralLagChange(ComparedFigure):
    """Lag of the integral term in one window less that in another, s; several windows on a side are averaged."""

    shown: ClassVar[Shown] = "quantity"

    kind: Literal["integral_lag_change"]
    axis: Axis

    @property
    def unit(self) -> str:
        """Second."""
        return "s"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the difference; None if a lag is missing."""
        sides = []
        for windows in (self.baseline, self.compared):
            lags = [_lag(run, scenario, window, AXES.index(self.axis)) for window in windows]
            known = [lag for lag in lags if lag is not None]
            if len(known) < len(lags):
                return Measurement(None)
            sides.append(sum(known) / len(known))
        return Measurement(sides[1] - sides[0])


def _lag(run: RunData, scenario: Scenario, window: str, index: int) -> float | None:
    span = scenario.windows[window]
    proportional, integral = (run[name].window(*span) for name in ("proportional", "integral"))
    p = proportional.values[:, index]
    peak = int(np.argmax(np.abs(p)))
    side = float(np.sign(p[peak]))
    other_side = np.flatnonzero(side * p[:peak] <= 0.0)
    begin = float(proportional.t[other_side[-1] + 1]) if len(other_side) else span[0]
    after = integral.t >= begin - 5e-7  # stamps are whole nanoseconds
    there = np.flatnonzero(after & (side * integral.values[:, index] >= 0.0))
    return float(integral.t[there[0]]) - begin if len(there) else None
