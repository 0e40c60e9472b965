"""Figures of position."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.figures.samples import column, rms, std
from dp_tools.run_data import RunData
from dp_tools.signals import position_error
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Place = Literal["north", "east", "heading"]
PLACES: tuple[Place, ...] = ("north", "east", "heading")


class PositionError(WindowFigure):
    """Deviation from the reference over a window, m or deg."""

    kind: Literal["position_error"]
    axis: Place
    of: Literal["estimate", "truth"] = "estimate"
    statistic: Literal["std", "rms", "max"]

    @property
    def unit(self) -> str:
        """Metre or degree."""
        return "deg" if self.axis == "heading" else "m"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic; "max" is that of the magnitude."""
        error = column(position_error(run, f"{self.of}_position"), scenario, self.window, PLACES.index(self.axis))
        if self.unit == "deg":
            error = np.degrees(error)
        if self.statistic == "max":
            return Measurement(float(np.abs(error).max()))
        return Measurement.of(std if self.statistic == "std" else rms, error)
