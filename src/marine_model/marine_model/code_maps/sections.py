"""The section ``drive`` of a thruster in a vessel file: tables with a column for every speed, as in print."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Self, TypeVar

from pydantic import Field, model_validator

from marine_model.code_maps.code_from_thrust import CodeFromThrust
from marine_model.code_maps.drive import CodeDrive
from marine_model.code_maps.rest_code_from_thrust import RestCodeFromThrust
from marine_model.code_maps.speeds import Speeds
from marine_model.code_maps.thrust_from_code import ThrustFromCode
from marine_model.errors import InputError
from marine_model.propellers.base import PropellerModel
from marine_model.schema import FieldError, NonNegative, Positive, Section
from marine_model.units import Unit

T = TypeVar("T")

Columns = Annotated[tuple[float, ...], Field(strict=False)]
CubicTerms = Annotated[
    tuple[float, float, float, float], Field(strict=False), Unit("1, 1/N, 1/N^2, 1/N^3")
]  # lowest power first


class ThrustFromCodeData(Section):
    """[Kostenko] (4), Table 2: a number for every speed."""

    constant: Annotated[Columns, Unit("N")]  # K_F0
    linear: Annotated[Columns, Unit("N")]  # K_F1
    quadratic: Annotated[Columns, Unit("N")]  # K_F2


class CodeFromThrustData(Section):
    """[Kostenko] (8), Table 4: a number for every speed."""

    thrust_max: Annotated[Columns, Unit("N")]
    constant: Annotated[Columns, Unit("1")]  # K_N0S
    linear: Annotated[Columns, Unit("1/N")]  # K_N1S
    quadratic: Annotated[Columns, Unit("1/N^2")]  # K_N2S
    cubic: Annotated[Columns, Unit("1/N^3")]  # K_N3S
    dead_zone: Annotated[Positive, Unit("N")]  # no code for thrust up to this


class RestCodeFromThrustData(Section):
    """[Kostenko] (7), Table 3."""

    ahead: CubicTerms  # K_N00 to K_N03
    astern: CubicTerms  # K_N10 to K_N13, of negative thrust
    thrust_max: Annotated[Positive, Unit("N")]  # either way
    dead_zone: Annotated[Positive, Unit("N")]  # no code for thrust up to this


class DriveData(Section):
    """A drive that is asked for integer codes."""

    code_max: Annotated[int, Field(ge=1, le=32767)]  # codes are from -code_max to code_max
    speed: Annotated[Columns, Unit("m/s")]  # of the columns
    thrust_from_code: ThrustFromCodeData
    code_from_thrust: CodeFromThrustData
    rest_code_from_thrust: RestCodeFromThrustData
    torque_droop: Annotated[NonNegative, Unit("N m/Hz")] = 0.0  # fall of the torque of a code with the shaft speed

    @model_validator(mode="after")
    def _good(self) -> Self:
        speeds = _blamed((), self._speeds)
        _blamed(("thrust_from_code",), lambda: self._thrust_from_code(speeds))
        _blamed(("code_from_thrust",), lambda: self._code_from_thrust(speeds))
        _blamed(("rest_code_from_thrust",), self._rest_code_from_thrust)
        return self

    def build(self, propeller: PropellerModel, density: float) -> CodeDrive:
        """Return the drive of a thruster with ``propeller`` in water of ``density`` (kg/m^3)."""
        speeds = self._speeds()
        return CodeDrive(
            self._thrust_from_code(speeds),
            self._code_from_thrust(speeds),
            self._rest_code_from_thrust(),
            propeller,
            density,
            self.torque_droop,
        )

    def _speeds(self) -> Speeds:
        return Speeds(self.speed)

    def _thrust_from_code(self, speeds: Speeds) -> ThrustFromCode:
        data = self.thrust_from_code
        return ThrustFromCode(speeds, data.constant, data.linear, data.quadratic, self.code_max)

    def _code_from_thrust(self, speeds: Speeds) -> CodeFromThrust:
        data = self.code_from_thrust
        return CodeFromThrust(
            speeds,
            data.thrust_max,
            data.constant,
            data.linear,
            data.quadratic,
            data.cubic,
            data.dead_zone,
            self.code_max,
        )

    def _rest_code_from_thrust(self) -> RestCodeFromThrust:
        data = self.rest_code_from_thrust
        return RestCodeFromThrust(data.ahead, data.astern, data.thrust_max, data.dead_zone, self.code_max)


def _blamed(place: tuple[str, ...], build: Callable[[], T]) -> T:
    try:
        return build()
    except InputError as error:
        name, _, message = str(error).partition(": ")
        field, _, index = name.partition("[")
        raise FieldError((*place, field, *([int(index[:-1])] if index else [])), message) from error
