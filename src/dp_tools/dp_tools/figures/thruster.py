"""Figures of single thrusters: thrust, direction, ventilation, limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import ComparedFigure, FigureSpec, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import column, mean, relative_change
from dp_tools.limits import limits_violations
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class ThrustLevel(WindowFigure):
    """Mean or largest magnitude of the commanded thrust of one thruster over a window, N."""

    kind: Literal["thrust_level"]
    thruster: str
    statistic: Literal["mean", "max"] = "mean"

    @property
    def unit(self) -> str:
        """Newton."""
        return "N"

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the statistic."""
        levels = _thrust(self.thruster, self.window, run, scenario)
        return Measurement.of(mean, levels) if self.statistic == "mean" else Measurement(float(levels.max()))


class ThrustLevelChange(ComparedFigure):
    """Mean magnitude of the commanded thrust of one thruster in one window over that in another, minus one."""

    kind: Literal["thrust_level_change"]
    thruster: str

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        levels = [_thrust(self.thruster, window, run, scenario) for window in (self.baseline, self.compared)]
        return Measurement.of(relative_change, *levels)


class VentilatingShare(WindowFigure):
    """Share of a window in which a thruster was flagged as ventilating."""

    shown: ClassVar[Shown] = "share"

    kind: Literal["ventilating_share"]
    thruster: str

    @property
    def unit(self) -> str:
        """1: a ratio."""
        return "1"

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the share."""
        flags = column(run["ventilating"], scenario, self.window, run.thrusters.index(self.thruster))
        return Measurement.of(mean, flags)


class TorqueLossLevel(WindowFigure):
    """Mean torque loss factor beta_Q2 that the drivers remember of one thruster, over a window."""

    kind: Literal["torque_loss_level"]
    thruster: str

    @property
    def unit(self) -> str:
        """1: a ratio."""
        return "1"

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the mean."""
        losses = column(run["beta_q2"], scenario, self.window, run.thrusters.index(self.thruster))
        return Measurement.of(mean, losses)


class TorqueLossChange(ComparedFigure):
    """Mean beta_Q2 of one thruster over one window over that of another, minus one; positive where it loses less."""

    kind: Literal["torque_loss_change"]
    thruster: str

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the relative change."""
        j = run.thrusters.index(self.thruster)
        losses = [column(run["beta_q2"], scenario, windows, j) for windows in (self.baseline, self.compared)]
        return Measurement.of(relative_change, *losses)


class AzimuthStep(FigureSpec):
    """Largest turn of a commanded direction between two samples, deg."""

    kind: Literal["azimuth_step"]
    window: str = ""  # empty: the whole run

    @property
    def unit(self) -> str:
        """Degree."""
        return "deg"

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

    kind: Literal["limit_violation_count"]

    @property
    def unit(self) -> str:
        """1: a count."""
        return "1"

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the count."""
        return Measurement(float(sum(check.violations for check in limits_violations(run, vessel))))


def _thrust(thruster: str, window: str | tuple[str, ...], run: RunData, scenario: Scenario) -> FloatArray:
    """Return the magnitude of the commanded thrust of one thruster over a window, N."""
    return np.abs(column(run["thrust_command"], scenario, window, run.thrusters.index(thruster)))
