"""Figures of spectra: how much of a signal's unrest is at one frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from dp_tools.figures.base import ComparedFigure, FigureSpec, Measurement, Shown, WindowFigure
from dp_tools.figures.samples import mean
from dp_tools.run_data import RunData, Series
from dp_tools.signals import total_power
from dp_tools.spectra import band_energies
from marine_model.guards import FloatArray
from marine_model.schema import Positive
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario
    from marine_model import Vessel

Signal = Literal["total_power", "motor_torque"]
# Of energies.
UNITS: dict[Signal, str] = {"total_power": "W^2", "motor_torque": "N^2 m^2"}


def signal_of(run: RunData, signal: Signal, thruster: str) -> Series:
    """Return total power (W), or the motor torque of one thruster (N m), as one column."""
    if signal == "total_power":
        return total_power(run)
    torque, j = run["motor_torque"], run.thrusters.index(thruster)
    return Series(torque.t, torque.values[:, j : j + 1])


class _BandFigure(FigureSpec):
    signal: Signal
    thruster: str = ""  # for motor_torque
    frequency: Annotated[Positive, Unit("Hz")]  # middle of the band
    bandwidth: Annotated[Positive, Unit("Hz")]  # whole width

    @model_validator(mode="after")
    def _one_signal(self) -> Self:
        if (self.signal == "motor_torque") != bool(self.thruster):
            raise ValueError(f"thruster: expected one with motor_torque only, found '{self.thruster}'")
        return self

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster, if there is one."""
        return (("thruster", self.thruster),) if self.thruster else ()

    def _energies(self, run: RunData, scenario: Scenario, windows: tuple[str, ...]) -> FloatArray:
        series = signal_of(run, self.signal, self.thruster)
        parts = [
            band_energies(series.window(*scenario.windows[window]), self.frequency, self.bandwidth)
            for window in windows
        ]
        return np.concatenate(parts)


class SpectralEnergy(_BandFigure, WindowFigure):
    """Energy of a signal in a band of frequencies over a window, in the square of its unit."""

    kind: Literal["spectral_energy"]

    @property
    def unit(self) -> str:
        """Square of the signal's unit."""
        return UNITS[self.signal]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return Welch's estimate."""
        return Measurement.of(mean, self._energies(run, scenario, (self.window,)))


class SpectralEnergyRatio(_BandFigure, ComparedFigure):
    """Energy of a signal in a band of frequencies over one window over that of another."""

    shown: ClassVar[Shown] = "quantity"

    kind: Literal["spectral_energy_ratio"]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the ratio."""
        sides = [self._energies(run, scenario, windows) for windows in (self.baseline, self.compared)]
        return Measurement.of(_ratio, *sides)


def _ratio(baseline: FloatArray, compared: FloatArray) -> float:
    return float(compared.mean() / baseline.mean())
