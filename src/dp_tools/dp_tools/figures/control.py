"""Figures of the terms of the controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import PlaneAxis, axis_unit, column, relative_change_of, rms
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.axes import HORIZONTAL

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Term = Literal["proportional", "integral", "derivative"]
Changing = Literal["proportional", "integral"]


class ControlTermLevel(WindowFigure):
    """Root mean square or largest magnitude of a term of the controller over a window, N or N m."""

    kind: Literal["control_term_level"]
    term: Term
    axis: PlaneAxis
    statistic: Literal["rms", "max"]

    @property
    def unit(self) -> str:
        """Newton or newton metre."""
        return axis_unit(self.axis)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        values = column(run[self.term], scenario, self.window, HORIZONTAL.index(self.axis))
        return Measurement(float(np.abs(values).max())) if self.statistic == "max" else Measurement.of(rms, values)


class ControlTermChange(ComparedFigure):
    """That of one window over that of another, minus one; "max" is the mean of the largest of each window."""

    kind: Literal["control_term_change"]
    term: Term
    axis: PlaneAxis
    statistic: Literal["rms", "max"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        index = HORIZONTAL.index(self.axis)
        if self.statistic == "rms":
            return Measurement.of(relative_change_of(rms), *self.sides(run[self.term], scenario, index))
        off, on = (
            np.mean([np.abs(column(run[self.term], scenario, window, index)).max() for window in windows])
            for windows in (self.baseline, self.compared)
        )
        return Measurement(float(on / off) - 1.0)


class SignChange(WindowFigure):
    """When a term changes sign into the largest excursion of the proportional term in a window, s since its start.

    For the proportional term that is where the excursion begins; for the integral term, when it comes to the same side,
    be it before or after.
    """

    unit: ClassVar[str] = "s"

    kind: Literal["sign_change"]
    term: Changing
    axis: PlaneAxis

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the time; None if the integral term did not come to that side within the window."""
        return Measurement(_sign_change(run, scenario, self.window, self.term, HORIZONTAL.index(self.axis)))


class SignChangeShift(ComparedFigure):
    """That of one window less that of another, s; several windows on a side are averaged."""

    shown: ClassVar[Shown] = "quantity"
    unit: ClassVar[str] = "s"

    kind: Literal["sign_change_shift"]
    term: Changing
    axis: PlaneAxis

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the difference; None if a time is missing."""
        sides = []
        for windows in (self.baseline, self.compared):
            times = [_sign_change(run, scenario, window, self.term, HORIZONTAL.index(self.axis)) for window in windows]
            known = [time for time in times if time is not None]
            if len(known) < len(times):
                return Measurement(None)
            sides.append(sum(known) / len(known))
        return Measurement(sides[1] - sides[0])


def _sign_change(run: RunData, scenario: Scenario, window: str, term: Changing, index: int) -> float | None:
    span = scenario.windows[window]
    proportional = run["proportional"].window(*span)
    p = proportional.values[:, index]
    peak = int(np.argmax(np.abs(p)))
    side = float(np.sign(p[peak]))
    if term == "proportional":
        changing, last = proportional, peak
    else:
        # Where it is on that side for the last time: from there backwards.
        changing = run["integral"].window(*span)
        there = np.flatnonzero(side * changing.values[:, index] > 0.0)
        if len(there) == 0:
            return None
        last = int(there[-1])
    other_side = np.flatnonzero(side * changing.values[:last, index] <= 0.0)
    first = int(other_side[-1]) + 1 if len(other_side) else 0
    return round(float(changing.t[first]) - span[0], 9)  # stamps are whole nanoseconds
