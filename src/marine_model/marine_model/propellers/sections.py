"""The section ``propeller`` of a thruster in a vessel file: one kind for every model."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from marine_model.errors import InputError
from marine_model.propellers.base import PropellerModel
from marine_model.propellers.bollard import BollardPropeller
from marine_model.propellers.four_quadrant import FourQuadrantPropeller, series_fault
from marine_model.propellers.polynomial import PolynomialPropeller
from marine_model.propellers.tabulated import TabulatedPropeller, pitch_range, table_fault
from marine_model.propellers.wageningen_b import AREA_RATIO, BLADES, PITCH_RATIO, WageningenBPropeller
from marine_model.schema import FieldError, Positive, Section, Vector3
from marine_model.units import Unit

Numbers = Annotated[tuple[float, ...], Field(strict=False), Unit("1")]
NumberRows = Annotated[tuple[Numbers, ...], Field(strict=False), Unit("1")]
Plain = Annotated[Positive, Unit("1")]


class BollardData(Section):
    """Open-water data near zero advance number, [Ruth] (3.4)-(3.7)."""

    model: Literal["bollard"] = "bollard"
    diameter: Annotated[Positive, Unit("m")]
    pitch_ratio: Plain  # P/D
    thrust_coefficient: Plain  # K_T(J=0)
    torque_coefficient: Plain  # K_Q(J=0)
    thrust_slope: Annotated[float, Field(le=0.0), Unit("1")] = 0.0  # a_T, dK_T/dJ
    torque_slope: Annotated[float, Field(le=0.0), Unit("1")] = 0.0  # a_Q, dK_Q/dJ

    def build(self) -> PropellerModel:
        """Return the model."""
        return BollardPropeller(
            self.diameter,
            self.pitch_ratio,
            self.thrust_coefficient,
            self.torque_coefficient,
            self.thrust_slope,
            self.torque_slope,
        )


class PolynomialData(Section):
    """Open-water coefficients quadratic in the advance number, [Kostenko] (2)."""

    model: Literal["polynomial"]
    diameter: Annotated[Positive, Unit("m")]
    pitch_ratio: Plain  # P/D
    thrust_polynomial: Annotated[Vector3, Unit("1")]  # K_T0, K_T1, K_T2
    torque_polynomial: Annotated[Vector3, Unit("1")]  # K_M0, K_M1, K_M2

    @model_validator(mode="after")
    def _falls(self) -> Self:
        try:
            self.build()
        except InputError as error:
            name, _, message = str(error).partition(": ")
            field, _, index = name.partition("[")
            raise FieldError((field, *([int(index[:-1])] if index else [])), message) from error
        return self

    def build(self) -> PropellerModel:
        """Return the model."""
        return PolynomialPropeller(self.diameter, self.pitch_ratio, self.thrust_polynomial, self.torque_polynomial)


class WageningenBData(Section):
    """A propeller of the Wageningen B-series."""

    model: Literal["wageningen_b"]
    diameter: Annotated[Positive, Unit("m")]
    blades: Annotated[int, Field(ge=BLADES[0], le=BLADES[1])]  # Z
    area_ratio: Annotated[float, Field(ge=AREA_RATIO[0], le=AREA_RATIO[1]), Unit("1")]  # A_E/A_0
    pitch_ratio: Annotated[float, Field(ge=PITCH_RATIO[0], le=PITCH_RATIO[1]), Unit("1")]  # P/D

    def build(self) -> PropellerModel:
        """Return the model."""
        return WageningenBPropeller(self.diameter, self.blades, self.area_ratio, self.pitch_ratio)


class FourQuadrantSeries(Section):
    """Fourier series of the advance angle, a row of coefficients for every pitch ratio; usually a file of its own."""

    source: str = ""
    pitch_ratio: Numbers
    thrust_cosine: NumberRows
    thrust_sine: NumberRows
    torque_cosine: NumberRows
    torque_sine: NumberRows

    @model_validator(mode="after")
    def _good(self) -> Self:
        rows = self.thrust_cosine, self.thrust_sine, self.torque_cosine, self.torque_sine
        fault = series_fault(self.pitch_ratio, *rows)
        if fault is not None:
            raise FieldError(*fault)
        return self


class FourQuadrantData(Section):
    """A propeller in four quadrants."""

    model: Literal["four_quadrant"]
    diameter: Annotated[Positive, Unit("m")]
    pitch_ratio: Plain  # P/D
    series: FourQuadrantSeries  # in the vessel file, or read by load_vessel from what it names under ``file``

    @model_validator(mode="after")
    def _pitch_known(self) -> Self:
        _check_pitch(self.series.pitch_ratio, self.pitch_ratio)
        return self

    def build(self) -> PropellerModel:
        """Return the model."""
        s = self.series
        return FourQuadrantPropeller(
            self.diameter,
            self.pitch_ratio,
            s.pitch_ratio,
            s.thrust_cosine,
            s.thrust_sine,
            s.torque_cosine,
            s.torque_sine,
        )


class PropellerTable(Section):
    """K_T and K_Q over J, a row for every pitch ratio; in the vessel file or a file of its own."""

    source: str = ""
    pitch_ratio: Numbers | None = None  # one row, that of the thruster's pitch ratio, when absent
    advance_number: Numbers
    thrust_coefficient: NumberRows
    torque_coefficient: NumberRows

    @model_validator(mode="after")
    def _good(self) -> Self:
        fault = table_fault(self.advance_number, self.thrust_coefficient, self.torque_coefficient, self.pitch_ratio)
        if fault is not None:
            raise FieldError(*fault)
        return self


class TabulatedData(Section):
    """A propeller known from a table."""

    model: Literal["tabulated"]
    diameter: Annotated[Positive, Unit("m")]
    pitch_ratio: Plain  # P/D
    table: PropellerTable  # in the vessel file, or read by load_vessel from what it names under ``file``

    @model_validator(mode="after")
    def _pitch_known(self) -> Self:
        if self.table.pitch_ratio is not None:
            _check_pitch(self.table.pitch_ratio, self.pitch_ratio)
        return self

    def build(self) -> PropellerModel:
        """Return the model."""
        t = self.table
        return TabulatedPropeller(
            self.diameter,
            self.pitch_ratio,
            t.advance_number,
            t.thrust_coefficient,
            t.torque_coefficient,
            t.pitch_ratio,
        )


# Models whose data may be in a file, named by a field ``file``, and the field that its content stands for.
DATA_FIELDS = {"four_quadrant": "series", "tabulated": "table"}
MODELS = ("bollard", "polynomial", "wageningen_b", "four_quadrant", "tabulated")


def _check_pitch(known: tuple[float, ...], design: float) -> None:
    try:
        limits = pitch_range(known, design)
    except InputError as error:
        raise FieldError(("pitch_ratio",), str(error).partition(": ")[2]) from error
    if limits is not None and not limits[0] <= design <= limits[1]:
        raise FieldError(
            ("pitch_ratio",),
            f"expected a number from {limits[0]:g} to {limits[1]:g}, those of the data, found {design:g}",
        )


def _told_apart(value: Any) -> Any:
    """Take a mapping without ``model`` for a bollard propeller; refuse a model that is not known."""
    if not isinstance(value, dict):
        return value
    model = value.get("model", "bollard")
    if model not in MODELS:
        raise FieldError(("model",), f"expected one of {', '.join(MODELS)}, found {model!r}")
    return {**value, "model": model}


PropellerData = Annotated[
    Annotated[
        BollardData | PolynomialData | WageningenBData | FourQuadrantData | TabulatedData, Field(discriminator="model")
    ],
    BeforeValidator(_told_apart),
]
