"""One thruster of a vessel: where it sits, what it can do, and what drives it."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from marine_model.code_maps.sections import DriveData
from marine_model.propellers.sections import PropellerData
from marine_model.schema import FieldError, NonNegative, Positive, Section, Vector3
from marine_model.sector import Direction, Sector, check_sectors
from marine_model.units import Unit

Triple = tuple[float, float, float]

# Directions are written down to four digits at least.
_LENGTH_TOLERANCE = 1e-4


class ThrustLimits(Section):
    """Magnitude and rate limits of commanded thrust, [Ruth] (4.5)-(4.6)."""

    min: Annotated[float, Unit("N")]  # most negative thrust; 0 where the thruster cannot reverse
    max: Annotated[Positive, Unit("N")]
    rate: Annotated[Positive, Unit("N/s")]  # largest rate of change either way

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min >= self.max:
            raise ValueError(f"thrust.min must be below thrust.max, found {self.min} and {self.max}")
        if self.min > 0.0:
            raise ValueError(f"thrust.min must not be above 0, found {self.min}")
        return self


class AzimuthLimits(Section):
    """Direction of the thruster force, [Ruth] (4.8)-(4.9)."""

    fixed: Direction  # direction when held fixed
    rate: Annotated[Positive, Unit("rad/s")]  # largest turning rate
    sectors: Annotated[tuple[Sector, ...], Field(strict=False)] = ()

    @model_validator(mode="after")
    def _sectors_agree(self) -> Self:
        check_sectors(self.sectors, self.fixed)
        return self


class ShaftDrive(Section):
    """Motor and shaft, referred to the propeller shaft."""

    inertia: Annotated[Positive, Unit("kg m^2")]  # rotor, shaft, propeller and entrained water
    torque_max: Annotated[Positive, Unit("N m")]  # motor torque limit either way
    friction_static: Annotated[NonNegative, Unit("N m")]  # Coulomb friction
    friction_viscous: Annotated[NonNegative, Unit("N m s")]  # per Hz of shaft speed
    power_max: Annotated[Positive | None, Unit("W")] = None  # largest |2 pi n Q| of the motor; none when absent
    speed_max: Annotated[Positive | None, Unit("Hz")] = None  # largest shaft speed either way; none when absent


class PitchDrive(Section):
    """Pitch actuator of a controllable-pitch propeller: a first-order lag with a largest rate."""

    min: Annotated[float, Unit("1")]  # P/D
    max: Annotated[float, Unit("1")]  # P/D
    rate: Annotated[Positive, Unit("1/s")]  # largest rate of change of P/D
    time_constant: Annotated[Positive, Unit("s")]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min >= self.max:
            raise ValueError(f"pitch.min must be below pitch.max, found {self.min} and {self.max}")
        return self


def check_pitch(propeller: PropellerData, low: float, high: float) -> None:
    """Raise FieldError, from a section with fields ``propeller`` and ``pitch`` on, if they do not fit together."""
    known = propeller.build().pitch_range
    if known is None:
        raise FieldError(
            ("pitch",), f"expected none, because the propeller model '{propeller.model}' knows one pitch ratio"
        )
    if not (known[0] <= low and high <= known[1]):
        raise FieldError(
            ("pitch",),
            f"expected min and max from {known[0]:g} to {known[1]:g}, those of the propeller's data, "
            f"found {low:g} and {high:g}",
        )
    if not low <= propeller.pitch_ratio <= high:
        raise FieldError(
            ("propeller", "pitch_ratio"),
            f"expected a number from pitch.min to pitch.max, {low:g} to {high:g}, found {propeller.pitch_ratio:g}",
        )


class AzimuthDrive(Section):
    """Azimuth motor: a rate servo."""

    rate_max: Annotated[Positive, Unit("rad/s")]  # what the motor can do
    time_constant: Annotated[Positive, Unit("s")]  # first-order lag from demanded to actual rate


class _Thruster(Section):
    name: str = Field(min_length=1, pattern=r"^[a-z][a-z0-9_]*$")
    # Body frame, from the calm waterline: ahead, to starboard, down (the depth of the shaft)
    position: Annotated[Vector3, Unit("m")]
    thrust: ThrustLimits
    propeller: PropellerData
    pitch: PitchDrive | None = None  # a controllable-pitch propeller; none when absent
    shaft: ShaftDrive
    drive: DriveData | None = None  # one that is asked for integer codes; none when absent

    @model_validator(mode="after")
    def _pitch_is_known(self) -> Self:
        if self.pitch is not None:
            check_pitch(self.propeller, self.pitch.min, self.pitch.max)
        return self

    @property
    def plane(self) -> tuple[Triple, Triple]:
        """n_1 and n_2 of [Ruth] (4.3): force directions, body frame, at azimuths 0 and pi/2."""
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


class TunnelThruster(_Thruster):
    """A thruster whose direction never changes and is horizontal."""

    type: Literal["tunnel"]
    direction: Direction  # 0 ahead, positive to starboard

    @property
    def fixed_direction(self) -> float:
        """Direction of positive thrust, rad."""
        return self.direction


class FixedThruster(_Thruster):
    """A thruster whose direction never changes, anywhere in space; its azimuth is 0."""

    type: Literal["fixed"]
    axis: Annotated[Vector3, Unit("1")]  # direction of positive thrust, body frame, of length 1

    @model_validator(mode="after")
    def _of_length_one(self) -> Self:
        length = math.hypot(*self.axis)
        if abs(length - 1.0) > _LENGTH_TOLERANCE:
            raise FieldError(("axis",), f"expected a vector of length 1, found {list(self.axis)} of {length:.6g}")
        return self

    @property
    def fixed_direction(self) -> float:
        """Azimuth of positive thrust in its own plane, rad: 0, along ``axis``."""
        return 0.0

    @property
    def plane(self) -> tuple[Triple, Triple]:
        """The axis, and nothing beside it."""
        x, y, z = self.axis
        length = math.hypot(x, y, z)
        return (x / length, y / length, z / length), (0.0, 0.0, 0.0)


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


Thruster = Annotated[TunnelThruster | AzimuthThruster | FixedThruster, Field(discriminator="type")]
