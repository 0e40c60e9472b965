"""Figures of how long the commanded generalized force is not the desired one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.schema import PositiveVector3
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class DeviationTime(WindowFigure):
    """Longest time on end in which the commanded force is off the desired one by more than a tolerance, s."""

    kind: Literal["deviation_time"]
    tolerance: Annotated[PositiveVector3, Unit("N, N, N m")]  # more than that in any axis counts

    @property
    def unit(self) -> str:
        """Second."""
        return "s"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the longest; a command holds until the next."""
        achieved = run["tau_achieved"].window(*scenario.windows[self.window])
        away = np.abs(achieved.values - run["tau_desired"].at(achieved.t)) > np.array(self.tolerance)
        flags = np.concatenate(([False], away.any(axis=1), [False]))
        edges = np.flatnonzero(np.diff(flags.astype(np.int8)))
        step = float(np.median(np.diff(achieved.t)))
        ends = np.append(achieved.t, achieved.t[-1] + step)
        lengths = ends[edges[1::2]] - achieved.t[edges[::2]]
        return Measurement(round(float(lengths.max()), 9) if len(lengths) else 0.0)  # stamps are whole ns


class ThrustStep(WindowFigure):
    """Largest change of a commanded thrust in a sample over a window, as a share of what its rate allows."""

    kind: Literal["thrust_step"]

    @property
    def unit(self) -> str:
        """1: a ratio."""
        return "1"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest of all thrusters."""
        thrust = run["thrust_command"].window(*scenario.windows[self.window])
        rate = np.abs(np.diff(thrust.values, axis=0)) / np.diff(thrust.t)[:, None]
        return Measurement(float((rate / vessel.thrust_rate).max()))
