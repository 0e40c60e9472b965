"""What every picture that a scenario asks for has."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from marine_model.schema import Section


class PlotSpec(Section):
    """One picture in a scenario file; a kind is a subclass, told apart by its field ``kind``."""

    title: str = Field(min_length=1)
    text: str = ""  # what to look at
    source: str = ""  # figure of the thesis that shows the same

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return (field, window name) of every window that this needs."""
        return ()

    def figure_names(self) -> tuple[str, ...]:
        """Return the names of the figures that this shows."""
        return ()

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return (field, thruster name) of every thruster that this needs."""
        return ()


class PartPlot(PlotSpec):
    """A picture of one window, or of the whole run."""

    window: str = ""  # empty: the whole run

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()


class GroupedPlot(PlotSpec):
    """A picture of several windows, e.g. two without and two with something."""

    # Windows by the name that the legend gives them; those of one name share a colour.
    groups: dict[str, Annotated[tuple[str, ...], Field(strict=False, min_length=1)]] = Field(min_length=1)

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the windows of all groups."""
        return tuple(("groups", window) for group in self.groups.values() for window in group)
