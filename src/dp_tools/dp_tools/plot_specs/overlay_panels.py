"""Windows laid over one another, with panels of one's own choice."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from dp_tools.plot_specs.base import GroupedPlot
from marine_model.schema import Section

PanelSignal = Literal["total_power", "thrust_command", "azimuth_command", "beta_q2"]


class Panel(Section):
    """One panel: the power of all thrusters, or a signal of one."""

    series: PanelSignal
    thruster: str = ""

    @model_validator(mode="after")
    def _whose(self) -> Self:
        if (self.series == "total_power") == bool(self.thruster):
            raise ValueError(f"thruster: expected one with every series but total_power, found '{self.thruster}'")
        return self


class OverlayPanels(GroupedPlot):
    """One signal a panel in several windows over the time since each began."""

    kind: Literal["overlay_panels"]
    panels: Annotated[tuple[Panel, ...], Field(strict=False, min_length=1)]

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thrusters of all panels."""
        return tuple(("panels", panel.thruster) for panel in self.panels if panel.thruster)
