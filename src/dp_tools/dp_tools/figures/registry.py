"""All kinds of figures, told apart by the field ``kind`` of a scenario file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from dp_tools.figures.attainable import AttainableSamples, GainLevel, LowGainSamples
from dp_tools.figures.force import ForceDeviation, ForceJump, ForceLevel, ForceMet, ForceTracking
from dp_tools.figures.joystick import TimeToDemand
from dp_tools.figures.lag import ActuatorLag
from dp_tools.figures.position import PositionError
from dp_tools.figures.power import MeanPower, MeanPowerChange
from dp_tools.figures.thruster import AzimuthStep, LimitViolations, ThrustLevel, ThrustLevelChange, VentilatingShare

AnyFigure = Annotated[
    MeanPower
    | MeanPowerChange
    | PositionError
    | ForceLevel
    | ForceTracking
    | ForceDeviation
    | ForceJump
    | ForceMet
    | TimeToDemand
    | AzimuthStep
    | ThrustLevel
    | ThrustLevelChange
    | VentilatingShare
    | ActuatorLag
    | AttainableSamples
    | GainLevel
    | LowGainSamples
    | LimitViolations,
    Field(discriminator="kind"),
]
