"""Figures of forbidden sectors: who dwells in them, how they are crossed, how often it is switched, [Ruth] 6.5.1."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import Measurement, Shown, WindowFigure
from dp_tools.run_data import RunData
from dp_tools.signals import runs_of
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from marine_model.sector import Sector
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

# Commands are clipped to their windows of one step; what is left is rounding of sums of angles.
_RELATIVE_TOLERANCE = 1e-9


class ForbiddenDwell(WindowFigure):
    """Time that directions spend inside forbidden sectors beyond what passing at full rate takes, all thrusters, s.

    A stay is a stretch of samples inside one sector. Passing takes its net turn over the largest azimuth rate, so that
    a thruster that turns back in a sector, slows down or stops there dwells.
    """

    unit: ClassVar[str] = "s"

    kind: Literal["forbidden_dwell"]
    of: Literal["commanded", "measured"] = "commanded"
    # How far inside a sector begins to count. A measured direction that rests at the end of a window is inside the
    # sector beside it half of the time, by noise.
    margin: Annotated[float, Unit("deg")] = 0.0

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the sum over all thrusters and sectors."""
        series = run["azimuth_command" if self.of == "commanded" else "azimuth"]
        part = series.window(*scenario.windows[self.window])
        total = 0.0
        for j, sectors in enumerate(vessel.sectors):
            for sector in sectors:
                if sector.kind == "forbidden":
                    angle, rate = part.values[:, j], float(vessel.azimuth_rate[j])
                    total += _dwell(part.t, angle, sector, math.radians(self.margin), rate)
        return Measurement(total)


class TransitFullRate(WindowFigure):
    """Share of the samples of a transit in which the thruster turns at its largest rate, or arrives.

    A transit is a stretch in which a thruster is outside its window, on the way to it.
    """

    shown: ClassVar[Shown] = "share"
    unit: ClassVar[str] = "1"

    kind: Literal["transit_full_rate"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the share; without a value where there was no transit."""
        crossing, command = run["crossing"], run["azimuth_command"]
        start, end = scenario.windows[self.window]
        flags = crossing.window(start, end).values > 0.5
        t = crossing.window(start, end).t
        rows = np.searchsorted(command.t, t - 5e-7)
        full = total = 0
        for j in range(flags.shape[1]):
            on_the_way = np.flatnonzero(flags[:, j])
            for i in on_the_way.tolist():
                if i == 0 or i + 1 == len(t):
                    continue  # where it comes from, or whether it arrives, lies outside
                total += 1
                angles = command.values[rows[i] - 1 : rows[i] + 1, j]
                turn = abs(float(wrap_angles(np.diff(angles))[0])) / float(t[i] - t[i - 1])
                arrives = not flags[i + 1, j]
                full += arrives or turn >= float(vessel.azimuth_rate[j]) * (1.0 - _RELATIVE_TOLERANCE)
        return Measurement(full / total if total else None)


class SwitchCount(WindowFigure):
    """How often something was switched over a window."""

    unit: ClassVar[str] = "1"

    kind: Literal["switch_count"]
    # sub_problem: the chosen combination of windows changes; transit: a thruster sets out for another window through
    # directions outside of it; azimuth_mode: between fixed and rotating.
    of: Literal["sub_problem", "transit", "azimuth_mode"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the count."""
        start, end = scenario.windows[self.window]
        if self.of == "azimuth_mode":
            # The first word is where it begins.
            return Measurement(float(sum(start <= t < end for t in run.labels["azimuth_mode"].t[1:].tolist())))
        if self.of == "sub_problem":
            return Measurement(float(np.count_nonzero(np.diff(run["sub_problem"].window(start, end).values[:, 0]))))
        flags = run["crossing"].window(start, end).values > 0.5
        return Measurement(float(np.count_nonzero(flags[1:] & ~flags[:-1])))


def inside(angle: FloatArray, sector: Sector, margin: float = 0.0) -> np.ndarray:
    """Return which of ``angle`` (rad) lie in a sector, farther than ``margin`` (rad) from its ends."""
    width = sector.width
    centre = sector.start + 0.5 * width
    # The ends belong to the directions beside; rounding must not put a thruster that rests there inside.
    return np.abs(wrap_angles(angle - centre)) < 0.5 * width - margin - _RELATIVE_TOLERANCE


def _dwell(t: FloatArray, angle: FloatArray, sector: Sector, margin: float, rate: float) -> float:
    """Return the time inside a sector beyond what its passages take at ``rate`` (rad/s), s."""
    total = 0.0
    for first, after in runs_of(inside(angle, sector, margin)):
        took = float(t[after - 1] - t[first])
        turned = abs(float(wrap_angles(angle[first:after][1:] - angle[first:after][:-1]).sum()))
        total += max(0.0, took - turned / rate)
    return total if total > _RELATIVE_TOLERANCE else 0.0
