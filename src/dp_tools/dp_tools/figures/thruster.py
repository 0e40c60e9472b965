"""Figures of single thrusters: thrust, direction, ventilation, limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, FigureSpec, Measurement, Shown, ThrusterFigure, WindowFigure
from dp_tools.figures.samples import column, mean, relative_change
from dp_tools.limits import limits_violations
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.frames import wrap_angles

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class ThrustLevel(ThrusterFigure, WindowFigure):
    """Mean or largest magnitude of the commanded thrust of one thruster over a window, N."""

    unit: ClassVar[str] = "N"

    kind: Literal["thrust_level"]
    statistic: Literal["mean", "max"] = "mean"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        levels = np.abs(column(run["thrust_command"], scenario, self.window, run.thrusters.index(self.thruster)))
        return Measurement.of(mean, levels) if self.statistic == "mean" else Measurement(float(levels.max()))


class ThrustLevelChange(ThrusterFigure, ComparedFigure):
    """Mean magnitude of the commanded thrust of one thruster in one window over that in another, minus one."""

    kind: Literal["thrust_level_change"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        sides = self.sides(run["thrust_command"], scenario, run.thrusters.index(self.thruster))
        return Measurement.of(relative_change, *map(np.abs, sides))


class ThrustDelivered(ThrusterFigure, WindowFigure):
    """Mean true thrust of one thruster over its mean commanded thrust in a window, minus one."""

    shown: ClassVar[Shown] = "change"
    unit: ClassVar[str] = "1"

    kind: Literal["thrust_delivered"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative difference; negative where the thruster gives less than it is asked for."""
        index = run.thrusters.index(self.thruster)
        asked, given = (column(run[name], scenario, self.window, index) for name in ("thrust_command", "truth_thrust"))
        return Measurement.of(relative_change, asked, given)


class VentilatingShare(ThrusterFigure, WindowFigure):
    """Share of a window in which a thruster was flagged as ventilating."""

    shown: ClassVar[Shown] = "share"
    unit: ClassVar[str] = "1"

    kind: Literal["ventilating_share"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the share."""
        flags = column(run["ventilating"], scenario, self.window, run.thrusters.index(self.thruster))
        return Measurement.of(mean, flags)


class TorqueLossLevel(ThrusterFigure, WindowFigure):
    """Mean torque loss factor beta_Q2 that the drivers remember of one thruster, over a window."""

    unit: ClassVar[str] = "1"

    kind: Literal["torque_loss_level"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the mean."""
        losses = column(run["beta_q2"], scenario, self.window, run.thrusters.index(self.thruster))
        return Measurement.of(mean, losses)


class TorqueLossChange(ThrusterFigure, ComparedFigure):
    """Mean beta_Q2 of one thruster over one window over that of another, minus one; positive where it loses less."""

    kind: Literal["torque_loss_change"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        sides = self.sides(run["beta_q2"], scenario, run.thrusters.index(self.thruster))
        return Measurement.of(relative_change, *sides)


class AzimuthStep(FigureSpec):
    """Largest turn of a commanded direction between two samples, deg."""

    unit: ClassVar[str] = "deg"

    kind: Literal["azimuth_step"]
    window: str = ""  # empty: the whole run

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the largest turn of any thruster."""
        azimuth = run["azimuth_command"]
        if self.window:
            azimuth = azimuth.window(*scenario.windows[self.window])
        turn = wrap_angles(np.diff(azimuth.values, axis=0))
        return Measurement(math.degrees(float(np.abs(turn).max())))


class LimitViolations(FigureSpec):
    """Number of samples of the whole run in which a limit of a thruster was broken."""

    unit: ClassVar[str] = "1"

    kind: Literal["limit_violation_count"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the count."""
        return Measurement(float(sum(check.violations for check in limits_violations(run, vessel))))
