"""One thruster of a vessel: where it sits, what it can do, and what drives it."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from marine_model.schema import NonNegative, Positive, Section, Vector3
from marine_model.sector import Direction, Sector, check_sectors


class ThrustLimits(Section):
    """Magnitude and rate limits of commanded thrust, [Ruth] (4.5)-(4.6)."""

    min: float  # N, most negative thrust; 0 where the thruster cannot reverse
    max: Positive  # N
    rate: Positive  # N/s, largest rate of change either way

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min >= self.max:
            raise ValueError(f"thrust.min must be below thrust.max, found {self.min} and {self.max}")
        if self.min > 0.0:
            raise ValueError(f"thrust.min must not be above 0, found {self.min}")
        return self


class AzimuthLimits(Section):
    """Direction of the thruster force, [Ruth] (4.8)-(4.9)."""

    fixed: Direction  # rad, direction when held fixed
    rate: Positive  # rad/s, largest turning rate
    sectors: Annotated[tuple[Sector, ...], Field(strict=False)] = ()

    @model_validator(mode="after")
    def _sectors_agree(self) -> Self:
        check_sectors(self.sectors, self.fixed)
        return self


class PropellerData(Section):
    """Open-water data at zero advance number."""

    diameter: Positive  # m
    thrust_coefficient: Positive  # K_T(J=0)
    torque_coefficient: Positive  # K_Q(J=0)


class ShaftDrive(Section):
    """Motor and shaft, referred to the propeller shaft."""

    inertia: Positive  # kg m^2, rotor, shaft, propeller and entrained water
    torque_max: Positive  # N m, motor torque limit either way
    friction_static: NonNegative  # N m, Coulomb friction
    friction_viscous: NonNegative  # N m s (per Hz of shaft speed)


class AzimuthDrive(Section):
    """Azimuth motor: a rate servo."""

    rate_max: Positive  # rad/s, what the motor can do
    time_constant: Positive  # s, first-order lag from demanded to actual rate


class _Thruster(Section):
    name: str = Field(min_length=1, pattern=r"^[a-z][a-z0-9_]*$")
    position: Vector3  # m, body frame: ahead, to starboard, down
    thrust: ThrustLimits
    propeller: PropellerData
    shaft: ShaftDrive


class TunnelThruster(_Thruster):
    """A thruster whose direction never changes."""

    type: Literal["tunnel"]
    direction: Direction  # rad, 0 ahead, positive to starboard

    @property
    def fixed_direction(self) -> float:
        """Direction of positive thrust, rad."""
        return self.direction


class AzimuthThruster(_Thruster):
    """A thruster that turns about a vertical axis."""

    type: Literal["azimuth"]
    azimuth: AzimuthLimits
    azimuth_drive: AzimuthDrive

    @model_validator(mode="after")
    def _servo_keeps_up(self) -> Self:
        if self.azimuth_drive.rate_max < self.azimuth.rate:
            raise ValueError(
                "azimuth_drive.rate_max must not be below azimuth.rate, found "
                f"{self.azimuth_drive.rate_max} and {self.azimuth.rate}"
            )
        return self

    @property
    def fixed_direction(self) -> float:
        """Direction of positive thrust while held fixed, rad."""
        return self.azimuth.fixed


Thruster = Annotated[TunnelThruster | AzimuthThruster, Field(discriminator="type")]
