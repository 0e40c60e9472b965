"""Figures of merit as bars."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from dp_tools.plot_specs.base import PlotSpec
from marine_model.units import Unit


class Bars(PlotSpec):
    """Figures of the scenario side by side, in the order given."""

    kind: Literal["bars"]
    figures: Annotated[tuple[str, ...], Field(strict=False, min_length=2)]  # names
    label: str = ""  # of the axis, with its unit
    logarithmic: bool = False
    level: Annotated[float | None, Unit("")] = None  # in the unit of the figures: a limit, drawn as a line

    def figure_names(self) -> tuple[str, ...]:
        """Return the figures."""
        return self.figures
