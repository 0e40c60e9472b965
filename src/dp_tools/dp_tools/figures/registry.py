"""All kinds of figures, told apart by the field ``kind`` of a scenario file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from dp_tools.figures.attainable import AttainableSamples, GainLevel, LowGainSamples
from dp_tools.figures.auto_mode import PerformanceLevel, TimeToMode
from dp_tools.figures.control import ControlTermChange, ControlTermLevel, SignChange, SignChangeShift
from dp_tools.figures.deviation import DeviationTime, ThrustStep
from dp_tools.figures.excursion import Badness, Excursion, RankAgreement
from dp_tools.figures.force import ForceDeviation, ForceJump, ForceLevel, ForceLevelChange, ForceMet, ForceTracking
from dp_tools.figures.joystick import TimeToDemand
from dp_tools.figures.lag import ActuatorLag
from dp_tools.figures.position import LargestErrorDelay, PositionError, PositionErrorChange, SpeedLevel
from dp_tools.figures.power import MeanPower, MeanPowerChange, PowerStdChange
from dp_tools.figures.sectors import ForbiddenDwell, SwitchCount, TransitFullRate
from dp_tools.figures.spectrum import SpectralEnergy, SpectralEnergyRatio
from dp_tools.figures.thruster import (
    AzimuthStep,
    LimitViolations,
    ThrustDelivered,
    ThrustLevel,
    ThrustLevelChange,
    TorqueLossChange,
    TorqueLossLevel,
    VentilatingShare,
)

AnyFigure = Annotated[
    MeanPower
    | MeanPowerChange
    | PowerStdChange
    | SpectralEnergy
    | SpectralEnergyRatio
    | PositionError
    | PositionErrorChange
    | LargestErrorDelay
    | SpeedLevel
    | ForceLevel
    | ForceLevelChange
    | ForceTracking
    | ForceDeviation
    | ForceJump
    | ControlTermLevel
    | ControlTermChange
    | SignChange
    | SignChangeShift
    | ForceMet
    | TimeToDemand
    | AzimuthStep
    | ThrustLevel
    | ThrustDelivered
    | ThrustLevelChange
    | VentilatingShare
    | TorqueLossLevel
    | TorqueLossChange
    | ForbiddenDwell
    | TransitFullRate
    | SwitchCount
    | DeviationTime
    | ThrustStep
    | PerformanceLevel
    | TimeToMode
    | Excursion
    | Badness
    | RankAgreement
    | ActuatorLag
    | AttainableSamples
    | GainLevel
    | LowGainSamples
    | LimitViolations,
    Field(discriminator="kind"),
]
