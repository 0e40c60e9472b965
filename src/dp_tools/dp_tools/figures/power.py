"""Figures of developed power."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from dp_tools.figures.base import ComparedFigure, Measurement, WindowFigure
from dp_tools.figures.samples import column, mean, relative_change, relative_change_of, std
from dp_tools.run_data import RunData
from dp_tools.signals import total_power
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class MeanPower(WindowFigure):
    """Mean of the developed power of all thrusters over a window, W."""

    unit: ClassVar[str] = "W"

    kind: Literal["mean_power"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the mean."""
        return Measurement.of(mean, column(total_power(run), scenario, self.window, 0))


class MeanPowerChange(ComparedFigure):
    """Mean developed power of one window over that of another, minus one."""

    kind: Literal["mean_power_change"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        return Measurement.of(relative_change, *self.sides(total_power(run), scenario, 0))


class PowerStdChange(ComparedFigure):
    """Standard deviation of the developed power of one window over that of another, minus one."""

    kind: Literal["power_std_change"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        return Measurement.of(relative_change_of(std), *self.sides(total_power(run), scenario, 0))
