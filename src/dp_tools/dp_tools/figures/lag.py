"""Figures of how actuators follow their commands."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import Measurement, ThrusterFigure, WindowFigure
from dp_tools.run_data import RunData, Series
from dp_tools.signals import measured_thrust
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angles

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

# Longer than any lag of actuators that keep up, in samples of the control system.
_LONGEST = 10.0


class ActuatorLag(ThrusterFigure, WindowFigure):
    """Time by which a measured direction or thrust comes behind its command over a window, s.

    The shift of the command that leaves the least mean square difference, in steps of the feedback.
    """

    unit: ClassVar[str] = "s"

    kind: Literal["actuator_lag"]
    of: Literal["azimuth", "thrust"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the shift."""
        j = run.thrusters.index(self.thruster)
        if self.of == "azimuth":
            command, whole = run["azimuth_command"], run["azimuth"]
        else:
            command, whole = run["thrust_command"], measured_thrust(run, vessel)
        measured = whole.window(*scenario.windows[self.window])
        if len(measured.t) < 2:
            raise InputError(f"window {self.window}: expected two samples or more, found {len(measured.t)}")
        step = float(measured.t[1] - measured.t[0])
        shifts = np.arange(round(_LONGEST * vessel.measurement.sample_time / step) + 1) * step
        errors = [self._error(command, measured, j, shift) for shift in shifts.tolist()]
        return Measurement(float(shifts[int(np.argmin(errors))]))

    def _error(self, command: Series, measured: Series, j: int, shift: float) -> float:
        """Return the mean square of measured minus shifted command."""
        error = measured.values[:, j] - command.at(measured.t - shift)[:, j]
        error = error[np.isfinite(error)]  # there is no command before the first
        if self.of == "azimuth":
            error = wrap_angles(error)
        return float(np.mean(error * error))
