"""Figures of position."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, Measurement, WindowFigure
from dp_tools.figures.samples import column, mean, relative_change_of, rms, std
from dp_tools.run_data import RunData
from dp_tools.signals import position_error
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Place = Literal["north", "east", "heading"]
# Of a submerged vehicle; in series of their own.
Below = Literal["depth", "roll", "pitch"]
PLACES: tuple[Place, ...] = ("north", "east", "heading")
BELOW: tuple[Below, ...] = ("depth", "roll", "pitch")
LENGTHS = ("north", "east", "depth")


class PositionError(WindowFigure):
    """Deviation from the reference over a window, m or deg."""

    kind: Literal["position_error"]
    axis: Place | Below
    of: Literal["estimate", "truth"] = "estimate"
    statistic: Literal["std", "rms", "max"]

    @property
    def unit(self) -> str:
        """Metre or degree."""
        return "m" if self.axis in LENGTHS else "deg"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic; "max" is that of the magnitude."""
        if self.axis in BELOW:
            name, index = f"vertical_{self.of}", BELOW.index(self.axis)
        else:
            name, index = f"{self.of}_position", PLACES.index(self.axis)
        error = column(position_error(run, name), scenario, self.window, index)
        if self.unit == "deg":
            error = np.degrees(error)
        if self.statistic == "max":
            return Measurement(float(np.abs(error).max()))
        return Measurement.of(std if self.statistic == "std" else rms, error)


class PositionErrorChange(ComparedFigure):
    """Deviation from the reference over one window over that of another, minus one."""

    kind: Literal["position_error_change"]
    axis: Place
    of: Literal["estimate", "truth"] = "estimate"
    statistic: Literal["std", "rms"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change of the statistic."""
        error = position_error(run, f"{self.of}_position")
        sides = self.sides(error, scenario, PLACES.index(self.axis))
        return Measurement.of(relative_change_of(std if self.statistic == "std" else rms), *sides)


class LargestErrorDelay(WindowFigure):
    """Time from the newest event until the largest deviation from the reference in a window, s."""

    unit: ClassVar[str] = "s"

    kind: Literal["largest_error_delay"]
    axis: Place

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the time; None if no event came before."""
        error = position_error(run, "estimate_position").window(*scenario.windows[self.window])
        largest = float(error.t[np.nanargmax(np.abs(error.values[:, PLACES.index(self.axis)]))])
        before = [event.at for event in scenario.events if event.at <= largest + 5e-7]  # stamps are whole ns
        return Measurement(largest - before[-1] if before else None)


class SpeedLevel(WindowFigure):
    """Mean of the estimated speed ahead over a window, m/s."""

    unit: ClassVar[str] = "m/s"

    kind: Literal["speed_level"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the mean."""
        return Measurement.of(mean, column(run["estimate_velocity"], scenario, self.window, 0))
