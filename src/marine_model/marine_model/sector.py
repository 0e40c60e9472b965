"""Sectors of directions that an azimuth thruster must not stay in, or may stay in with less thrust: [Ruth] 6.4.1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from marine_model.schema import FieldError, Fraction, Section
from marine_model.units import Unit

_TWO_PI = 2.0 * math.pi
# rad; ends this close are one end. Far above the rounding of degrees into radians, far below what a thruster can do.
ANGLE_TOLERANCE = 1e-9

Direction = Annotated[float, Field(ge=-math.pi, le=math.pi), Unit("rad")]


class Sector(Section):
    """Directions from ``start`` to ``end``, turning with increasing azimuth; may pass through pi."""

    start: Direction
    end: Direction
    kind: Literal["forbidden", "reduced"]
    # Share of thrust.max: forbidden, while the thruster passes; reduced, while it points there.
    thrust_factor: Fraction = 1.0

    @model_validator(mode="after")
    def _is_a_sector(self) -> Self:
        if self.width < ANGLE_TOLERANCE:
            raise ValueError(f"expected start and end that differ, found {self.start} and {self.end}")
        if self.kind == "reduced" and "thrust_factor" not in self.model_fields_set:
            raise FieldError(("thrust_factor",), "a reduced sector has to say how much thrust is left")
        return self

    @property
    def width(self) -> float:
        """Angle from start to end, rad in [0, 2 pi]; from -pi to pi is the whole circle."""
        width = self.end - self.start
        return width if width >= 0.0 else width + _TWO_PI

    def has_inside(self, angle: float) -> bool:
        """Return whether ``angle`` (rad) lies in the sector and not on one of its ends."""
        beyond_start = (angle - self.start) % _TWO_PI
        return ANGLE_TOLERANCE < beyond_start < self.width - ANGLE_TOLERANCE

    def overlaps(self, other: Sector) -> bool:
        """Return whether the two have more in common than an end."""
        from_here = (other.start - self.start) % _TWO_PI
        from_there = (self.start - other.start) % _TWO_PI
        return from_here < self.width - ANGLE_TOLERANCE or from_there < other.width - ANGLE_TOLERANCE


def check_sectors(sectors: Sequence[Sector], fixed: float) -> None:
    """Check the sectors of one thruster against each other and against its fixed direction (rad).

    Raises
    ------
    FieldError
        If two overlap, all directions are forbidden, or the fixed direction is.
    """
    for i, sector in enumerate(sectors):
        for k, other in enumerate(sectors[:i]):
            if sector.overlaps(other):
                raise FieldError(
                    ("sectors", i),
                    f"must not overlap another sector, found {sector.start} to {sector.end} "
                    f"beside sectors.{k}, {other.start} to {other.end}",
                )
    forbidden = [sector for sector in sectors if sector.kind == "forbidden"]
    if sum(sector.width for sector in forbidden) > _TWO_PI - len(forbidden) * ANGLE_TOLERANCE:
        raise FieldError(("sectors",), "together they forbid every direction")
    for sector in forbidden:
        if sector.has_inside(fixed):
            raise FieldError(
                ("fixed",), f"must not lie in a forbidden sector, found {fixed} in {sector.start} to {sector.end}"
            )
