"""Figures of the supervisor that chooses between fixed and rotating thrusters, [Ruth] (6.3)-(6.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.figures.samples import column, mean
from dp_tools.run_data import RunData
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class PerformanceLevel(WindowFigure):
    """Filtered surge-sway demand that azimuth_mode auto decides by: largest, smallest or mean of a window, N."""

    unit: ClassVar[str] = "N"

    kind: Literal["performance_level"]
    statistic: Literal["max", "min", "mean"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        values = column(run["performance_measure"], scenario, self.window, 0)
        if self.statistic == "mean":
            return Measurement.of(mean, values)
        return Measurement(float(values.max() if self.statistic == "max" else values.min()))


class TimeToMode(WindowFigure):
    """Time from the start of a window until azimuth thrusters begin to rotate, or to be held, s."""

    unit: ClassVar[str] = "s"

    kind: Literal["time_to_mode"]
    mode: Literal["fixed", "rotating"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the time; without a value where the window ends before."""
        start, end = scenario.windows[self.window]
        labels = run.labels["azimuth_mode"]
        changed = [
            t for t, word in zip(labels.t.tolist(), labels.words, strict=True) if start <= t < end and word == self.mode
        ]
        return Measurement(round(changed[0] - start, 9) if changed else None)  # stamps are whole ns
