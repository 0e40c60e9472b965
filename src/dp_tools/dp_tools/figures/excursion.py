"""Figures of how far a vessel is driven off, and which of several failures is the worst."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from dp_tools.figures.base import FigureSpec, Measurement, WindowFigure
from dp_tools.figures.samples import rms
from dp_tools.run_data import RunData
from dp_tools.signals import position_error
from marine_model import Vessel
from marine_model.guards import FloatArray
from marine_model.schema import Positive
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class _Scaled(FigureSpec):
    """What an excursion is measured by."""

    unit: ClassVar[str] = "1"

    lengths: Annotated[Positive, Unit("1")]  # distance, in lengths of the ship: the same at every scale
    heading: Annotated[Positive, Unit("deg")]
    of: Literal["estimate", "truth"] = "estimate"

    def _excursion(self, run: RunData, scenario: Scenario, vessel: Vessel, window: str, both: bool) -> FloatArray:
        """Return distance from the reference over ``lengths`` ships and heading error over ``heading``.

        The larger of the two at every sample, or with ``both`` the root of the sum of their squares.
        """
        error = position_error(run, f"{self.of}_position").window(*scenario.windows[window]).values
        error = error[np.isfinite(error).all(axis=1)]
        away = np.hypot(error[:, 0], error[:, 1]) / (self.lengths * vessel.hull.length)
        turned = np.abs(error[:, 2]) / math.radians(self.heading)
        return np.hypot(away, turned) if both else np.maximum(away, turned)


class Excursion(_Scaled, WindowFigure):
    """Largest excursion over a window: distance over ``lengths`` ships, or heading error over ``heading``, if larger.

    Position counts as lost above 1.
    """

    kind: Literal["excursion"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest."""
        return Measurement(float(self._excursion(run, scenario, vessel, self.window, both=False).max()))


class Badness(_Scaled, WindowFigure):
    """Root mean square over a window of distance over ``lengths`` ships and heading error over ``heading``, as one."""

    kind: Literal["badness"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the root mean square."""
        return Measurement(rms(self._excursion(run, scenario, vessel, self.window, both=True)))


class RankAgreement(_Scaled):
    """Spearman's rank correlation of the badness of several windows with the order in which they are named."""

    kind: Literal["rank_agreement"]
    worst_first: Annotated[tuple[str, ...], Field(strict=False, min_length=3)]  # windows

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return all windows."""
        return tuple(("worst_first", window) for window in self.worst_first)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the correlation: 1 for the same order, -1 for its reverse."""
        bad = [rms(self._excursion(run, scenario, vessel, window, both=True)) for window in self.worst_first]
        expected = np.arange(len(bad), 0, -1)
        # Here: its import takes as long as all the rest of the command together.
        from scipy.stats import spearmanr

        return Measurement(float(spearmanr(expected, bad).statistic))
