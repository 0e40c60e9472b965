"""All kinds of pictures that a scenario can ask for."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from dp_tools.plot_specs.bars import Bars
from dp_tools.plot_specs.fault_plot import FaultPlot
from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.plot_specs.mode_plot import ModePlot
from dp_tools.plot_specs.overlay import Overlay
from dp_tools.plot_specs.overlay_panels import OverlayPanels
from dp_tools.plot_specs.sector_plot import SectorPlot
from dp_tools.plot_specs.spectra import Spectra
from dp_tools.plot_specs.thrust_and_loss import ThrustAndLoss

AnyPlot = Annotated[
    Overlay
    | OverlayPanels
    | Spectra
    | ThrustAndLoss
    | SectorPlot
    | ModePlot
    | FaultPlot
    | Bars
    | AttainablePlot
    | MinimumGains,
    Field(discriminator="kind"),
]
