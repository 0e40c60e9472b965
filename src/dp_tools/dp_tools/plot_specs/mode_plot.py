"""What chooses between fixed and rotating thrusters."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PlotSpec


class ModePlot(PlotSpec):
    """Filtered demand with the hysteresis of azimuth_mode auto, and directions of the azimuth thrusters."""

    kind: Literal["auto_mode"]
