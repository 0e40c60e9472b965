"""Base class and field types of everything read from a YAML document."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class FieldError(ValueError):
    """Raised by a validator of a section to blame one field in it, ``field`` from the section on."""

    def __init__(self, field: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.field = field


class Section(BaseModel):
    """A frozen mapping of a YAML document: unknown fields, strings for numbers and NaN are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]

# YAML knows lists only; strict mode would refuse them for tuples without this.
Vector3 = Annotated[tuple[float, float, float], Field(strict=False)]
PositiveVector3 = Annotated[tuple[Positive, Positive, Positive], Field(strict=False)]
NonNegativeVector3 = Annotated[tuple[NonNegative, NonNegative, NonNegative], Field(strict=False)]
Matrix3 = Annotated[tuple[Vector3, Vector3, Vector3], Field(strict=False)]
