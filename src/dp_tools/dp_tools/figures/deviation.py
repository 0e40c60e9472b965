"""Figures of how long the commanded generalized force is not the desired one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.run_data import RunData
from dp_tools.signals import runs_of
from marine_model import Vessel
from marine_model.schema import PositiveVector3
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class DeviationTime(WindowFigure):
    """Longest time on end in which the commanded force is off the desired one by more than a tolerance, s."""

    unit: ClassVar[str] = "s"

    kind: Literal["deviation_time"]
    tolerance: Annotated[PositiveVector3, Unit("N, N, N m")]  # more than that in any axis counts

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the longest; a command holds until the next."""
        achieved = run["tau_achieved"].window(*scenario.windows[self.window])
        away = np.abs(achieved.values - run["tau_desired"].at(achieved.t)) > np.array(self.tolerance)
        step = float(np.median(np.diff(achieved.t)))
        ends = np.append(achieved.t, achieved.t[-1] + step)
        lengths = [float(ends[after] - ends[first]) for first, after in runs_of(np.asarray(away.any(axis=1)))]
        return Measurement(round(max(lengths, default=0.0), 9))  # stamps are whole ns


class ThrustStep(WindowFigure):
    """Largest change of a commanded thrust in a sample over a window, as a share of what its rate allows."""

    unit: ClassVar[str] = "1"

    kind: Literal["thrust_step"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest of all thrusters."""
        thrust = run["thrust_command"].window(*scenario.windows[self.window])
        rate = np.abs(np.diff(thrust.values, axis=0)) / np.diff(thrust.t)[:, None]
        return Measurement(float((rate / vessel.thrust_rate).max()))
