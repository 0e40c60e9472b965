"""Base class and field types of everything read from a YAML document."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from marine_model.units import Unit


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
Fraction = Annotated[float, Field(ge=0.0, le=1.0), Unit("1")]

# YAML knows lists only; strict mode would refuse them for tuples without this.
Vector3 = Annotated[tuple[float, float, float], Field(strict=False)]
PositiveVector3 = Annotated[tuple[Positive, Positive, Positive], Field(strict=False)]
NonNegativeVector3 = Annotated[tuple[NonNegative, NonNegative, NonNegative], Field(strict=False)]
Matrix3 = Annotated[tuple[Vector3, Vector3, Vector3], Field(strict=False)]


def _one_is_a_list(value: Any) -> Any:
    return (value,) if isinstance(value, int | float) and not isinstance(value, bool) else value


# One number for all thrusters, or one for each in the order of the vessel file.
PositiveByThruster = Annotated[tuple[Positive, ...], Field(strict=False, min_length=1), BeforeValidator(_one_is_a_list)]
