"""Windows laid over one another."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from dp_tools.plot_specs.base import PlotSpec

# Series with a column for surge, sway, yaw or north, east, heading.
Vector = Literal["position_error", "proportional", "integral", "derivative", "tau_desired", "tau_achieved"]


class Overlay(PlotSpec):
    """The same signal in several windows over the time since each began."""

    kind: Literal["overlay"]
    series: Vector
    # Windows by the name that the legend gives them; those of one name share a colour.
    groups: dict[str, Annotated[tuple[str, ...], Field(strict=False, min_length=1)]] = Field(min_length=1)

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the windows of all groups."""
        return tuple(("groups", window) for group in self.groups.values() for window in group)
