"""Figures of generalized force."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import AXES, FORCE_UNITS, Axis, column, mean, relative_change, rms, std
from dp_tools.run_data import RunData, Series
from dp_tools.signals import measured_force
from marine_model import Vessel
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
        return FORCE_UNITS[self._index]

    @property
    def _index(self) -> int:
        return AXES.index(self.axis)

    def _column(self, series: Series, scenario: Scenario) -> FloatArray:
        return column(series, scenario, self.window, self._index)


class ForceLevel(_ForceFigure):
    """Mean or standard deviation of a generalized force over a window, N or N m."""

    kind: Literal["force_level"]
    force: Force
    statistic: Literal["mean", "std"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        series = _force(self.force, run, vessel)
        return Measurement.of(mean if self.statistic == "mean" else std, self._column(series, scenario))


class ForceLevelChange(ComparedFigure):
    """Mean of a generalized force over one window over that of another, minus one; negative where it became smaller."""

    kind: Literal["force_level_change"]
    force: Force
    axis: Axis

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        sides = self.sides(_force(self.force, run, vessel), scenario, AXES.index(self.axis))
        return Measurement.of(relative_change, *sides)


class ForceTracking(_ForceFigure):
    """Root mean square of measured minus commanded generalized force over a window, N or N m."""

    kind: Literal["force_tracking"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the root mean square."""
        measured = measured_force(run, vessel)
        error = Series(measured.t, measured.values - run["tau_achieved"].at(measured.t))
        return Measurement.of(rms, self._column(error, scenario))


class ForceDeviation(_ForceFigure):
    """Largest deviation of the commanded from the desired generalized force over a window, N or N m."""

    kind: Literal["force_deviation"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest magnitude."""
        desired, achieved = (self._column(run[name], scenario) for name in ("tau_desired", "tau_achieved"))
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
        desired, achieved = (self._column(run[name], scenario) for name in ("tau_desired", "tau_achieved"))
        return Measurement(float((np.abs(np.diff(achieved)) - np.abs(np.diff(desired))).max()))


def _force(name: Force, run: RunData, vessel: Vessel) -> Series:
    return measured_force(run, vessel) if name == "tau_measured" else run[name]
