"""Sub-problem and thrust directions, with the forbidden sectors."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PlotSpec


class SectorPlot(PlotSpec):
    """Chosen combination of windows, and directions of the azimuth thrusters over their forbidden sectors."""

    kind: Literal["sectors"]
    window: str = ""  # empty: the whole run

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()
