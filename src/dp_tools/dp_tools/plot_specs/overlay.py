"""Windows laid over one another."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import GroupedPlot

# Series with a column for surge, sway, yaw or north, east, heading.
Vector = Literal["position_error", "proportional", "integral", "derivative", "tau_desired", "tau_achieved"]


class Overlay(GroupedPlot):
    """The same signal in several windows over the time since each began."""

    kind: Literal["overlay"]
    series: Vector
