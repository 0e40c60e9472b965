"""Sub-problem and thrust directions, with the forbidden sectors."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PartPlot


class SectorPlot(PartPlot):
    """Chosen combination of windows, and directions of the azimuth thrusters over their forbidden sectors."""

    kind: Literal["sectors"]
