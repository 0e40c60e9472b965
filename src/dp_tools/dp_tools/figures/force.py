"""Figures of generalized force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import axis_unit, column, mean, relative_change, rms, series_of_axis, std
from dp_tools.run_data import RunData, Series
from dp_tools.signals import measured_force, measured_vertical_force
from marine_model import Vessel
from marine_model.axes import HORIZONTAL, VERTICAL, Axis
from marine_model.guards import FloatArray
from marine_model.schema import PositiveVector3
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


Force = Literal["tau_desired", "tau_achieved", "tau_measured"]


class _ForceFigure(WindowFigure):
    axis: Axis

    @property
    def unit(self) -> str:
        """Newton or newton metre."""
        return axis_unit(self.axis)

    def _column(self, name: Force, run: RunData, vessel: Vessel, scenario: Scenario) -> FloatArray:
        """Return the samples of the axis in the window."""
        series, index = _force(name, self.axis, run, vessel)
        return column(series, scenario, self.window, index)


class ForceLevel(_ForceFigure):
    """Mean or standard deviation of a generalized force over a window, N or N m."""

    kind: Literal["force_level"]
    force: Force
    statistic: Literal["mean", "std"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        values = self._column(self.force, run, vessel, scenario)
        return Measurement.of(mean if self.statistic == "mean" else std, values)


class ForceLevelChange(ComparedFigure):
    """Mean of a generalized force over one window over that of another, minus one; negative where it became smaller."""

    kind: Literal["force_level_change"]
    force: Force
    axis: Axis

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        series, index = _force(self.force, self.axis, run, vessel)
        sides = self.sides(series, scenario, index)
        return Measurement.of(relative_change, *sides)


class ForceTracking(_ForceFigure):
    """Root mean square of measured minus commanded generalized force over a window, N or N m."""

    kind: Literal["force_tracking"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the root mean square."""
        measured, index = _force("tau_measured", self.axis, run, vessel)
        commanded, _ = _force("tau_achieved", self.axis, run, vessel)
        error = Series(measured.t, measured.values - commanded.at(measured.t))
        return Measurement.of(rms, column(error, scenario, self.window, index))


class ForceDeviation(_ForceFigure):
    """Largest deviation of the commanded from the desired generalized force over a window, N or N m."""

    kind: Literal["force_deviation"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest magnitude."""
        desired = self._column("tau_desired", run, vessel, scenario)
        achieved = self._column("tau_achieved", run, vessel, scenario)
        return Measurement(float(np.abs(achieved - desired).max()))


class ForceMet(WindowFigure):
    """Share of a window in which the commanded force was within tolerance of the desired one in every axis."""

    shown: ClassVar[Shown] = "share"
    unit: ClassVar[str] = "1"

    kind: Literal["force_met"]
    tolerance: Annotated[PositiveVector3, Unit("N, N, N m")]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the share."""
        desired, achieved = (
            run[name].window(*scenario.windows[self.window]) for name in ("tau_desired", "tau_achieved")
        )
        met = (np.abs(achieved.values - desired.values) <= np.array(self.tolerance)).all(axis=1)
        return Measurement.of(mean, np.asarray(met, dtype=np.float64))


class ForceJump(_ForceFigure):
    """Most that the commanded force moved in a sample beyond what was desired, over a window, N or N m."""

    kind: Literal["force_jump"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest."""
        desired = self._column("tau_desired", run, vessel, scenario)
        achieved = self._column("tau_achieved", run, vessel, scenario)
        return Measurement(float((np.abs(np.diff(achieved)) - np.abs(np.diff(desired))).max()))


def _force(name: Force, axis: Axis, run: RunData, vessel: Vessel) -> tuple[Series, int]:
    """Return the series in which an axis of a force stands, and its column."""
    if name == "tau_measured":
        if axis in HORIZONTAL:
            return measured_force(run, vessel), HORIZONTAL.index(axis)
        return measured_vertical_force(run, vessel), VERTICAL.index(axis)
    series, index = series_of_axis(name, axis)
    return run[series], index
