"""What a trial file asks to be measured."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from dp_tools.open_water.case import Name
from dp_tools.open_water.measures import Kind
from dp_tools.open_water.surroundings import ThrustReference
from marine_model.schema import NonNegative, Positive, Section

Window = Annotated[tuple[NonNegative, Positive], Field(strict=False)]  # s, start and end


class Figure(Section):
    """One number of the trial, beside what the thesis prints."""

    name: Name
    title: str = Field(min_length=1)
    kind: Kind
    case: Name
    over: Name | None = None  # another case: the figure is the ratio to it
    window: Name
    thesis: float | None = None  # in the unit of the kind
    source: str = ""  # where it is printed
    reason: str = ""  # why ours may differ


class Table(Section):
    """Kinds of figures of every case, side by side."""

    window: Name
    kinds: Annotated[tuple[Kind, ...], Field(strict=False, min_length=1)]


class Variant(Section):
    """The trial with another thrust."""

    title: str = Field(min_length=1)
    thrust: ThrustReference


class Sweep(Section):
    """A kind of figure, as ratio of every case to the first one, for other thrusts than the trial's."""

    kind: Kind
    window: Window  # s; a variant runs until its end
    thesis: Annotated[tuple[float, ...], Field(strict=False)] | None = None  # the ratios, one a case
    source: str = ""
    variants: Annotated[tuple[Variant, ...], Field(strict=False, min_length=1)]
