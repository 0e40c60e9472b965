"""Spectra of several windows."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from dp_tools.plot_specs.base import GroupedPlot
from marine_model.schema import Positive
from marine_model.units import Unit


class Spectra(GroupedPlot):
    """Power spectral density of total power, or of the motor torque of some thrusters, one line a window."""

    kind: Literal["spectra"]
    signal: Literal["total_power", "motor_torque"]
    # For motor_torque, one panel each.
    of: Annotated[tuple[str, ...], Field(strict=False)] = ()
    segment: Annotated[Positive, Unit("s")]  # of Welch's method
    up_to: Annotated[Positive, Unit("Hz")]
    marked: Annotated[tuple[float, ...], Field(strict=False), Unit("Hz")] = ()  # thin lines

    @model_validator(mode="after")
    def _whose(self) -> Self:
        if (self.signal == "motor_torque") != bool(self.of):
            raise ValueError(f"of: expected thrusters with motor_torque only, found {list(self.of)}")
        return self

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thrusters."""
        return tuple(("of", thruster) for thruster in self.of)
