"""Position and which thrusters are faulty."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PlotSpec


class FaultPlot(PlotSpec):
    """Position and heading, and one row a thruster that is red while the thruster is faulty."""

    kind: Literal["faults"]
