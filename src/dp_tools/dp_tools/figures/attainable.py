"""Figures of what the thrusters could give: Theorem 7.3 of [Ruth], and minimum gains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.attainable import MISSED, Reverse, attainable
from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.figures.samples import column, mean
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.schema import Positive
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

Directions = Literal["both_ways", "push"]
_SERIES = {"both_ways": "minimum_gain_both_ways", "push": "minimum_gain"}
# A direction that moves less than this in a sample stands still: rounding of angles.
_STILL = 1e-9  # rad


class AttainableSamples(WindowFigure):
    """Samples whose demand Theorem 7.3 promises, or does not; all of them, or those in which force was missed.

    ``inside``: the scaled demand is no longer than sigma_min, and differs from what the thrusts of the sample before
    give by no more than thrusts of limited rate can follow (7.15). ``too_fast``: it is no longer than sigma_min, but
    differs more. ``beyond``: it is longer.
    """

    unit: ClassVar[str] = "1"

    kind: Literal["attainable_samples"]
    demand: Literal["inside", "too_fast", "beyond"]
    missed: bool = False  # count only samples in which force was missed
    reverse: Reverse = "as_ahead"
    tolerance: Annotated[Positive, Unit("1")] = MISSED  # missed force that counts, scaled

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the count."""
        part = attainable(run, vessel, self.reverse).within(*scenario.windows[self.window])
        found = {"inside": part.inside, "too_fast": part.too_fast, "beyond": part.beyond}[self.demand]
        if self.missed:
            found = found & (part.missed > self.tolerance)
        return Measurement(float(found.sum()))


class GainLevel(WindowFigure):
    """Mean or smallest minimum gain at the commanded directions over a window, without dimension."""

    unit: ClassVar[str] = "1"

    kind: Literal["gain_level"]
    directions: Directions = "both_ways"  # thrusters push both ways, or those that rotate one way only
    statistic: Literal["mean", "min"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        gains = column(run[_SERIES[self.directions]], scenario, self.window, 0)
        return Measurement.of(mean, gains) if self.statistic == "mean" else Measurement(float(gains.min()))


class LowGainSamples(WindowFigure):
    """Samples in which the minimum gain is below a limit; all, or those in which no thruster turned either."""

    unit: ClassVar[str] = "1"

    kind: Literal["low_gain_samples"]
    limit: Annotated[Positive, Unit("1")]
    directions: Directions = "both_ways"
    at_rest: bool = False

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the count."""
        gains = run[_SERIES[self.directions]].window(*scenario.windows[self.window])
        # A method that keeps the gain at its limit may be a rounding below it.
        low = gains.values[:, 0] < self.limit * (1.0 - 1e-6)
        if self.at_rest:
            azimuth = run["azimuth_command"]
            turn = np.zeros(len(azimuth.t))
            turn[1:] = np.abs(wrap_angles(np.diff(azimuth.values, axis=0))).max(axis=1)
            index = np.searchsorted(azimuth.t, gains.t + 5e-7, side="right") - 1
            low = low & (turn[index] < _STILL)
        return Measurement(float(low.sum()))
