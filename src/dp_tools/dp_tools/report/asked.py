"""The pictures that a scenario asks for: which function draws which kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from dp_tools.plot_specs import PlotSpec
from dp_tools.plot_specs.bars import Bars
from dp_tools.plot_specs.fault_plot import FaultPlot
from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.plot_specs.mode_plot import ModePlot
from dp_tools.plot_specs.overlay import Overlay
from dp_tools.plot_specs.overlay_panels import OverlayPanels
from dp_tools.plot_specs.sector_plot import SectorPlot
from dp_tools.plot_specs.spectra import Spectra
from dp_tools.plot_specs.thrust_and_loss import ThrustAndLoss
from dp_tools.report.bars import bars
from dp_tools.report.fault_plot import fault_plot
from dp_tools.report.gain import attainable_plot, minimum_gains
from dp_tools.report.mode_plot import mode_plot
from dp_tools.report.overlay import overlay
from dp_tools.report.overlay_panels import overlay_panels
from dp_tools.report.scene import Picture, Scene
from dp_tools.report.sector_plot import sector_plot
from dp_tools.report.spectra import spectra
from dp_tools.report.thrust_and_loss import thrust_and_loss

# Each takes the scene and a spec of its own kind, and returns the image as data URI, and in words what it shows.
_DRAWN_BY: dict[type[PlotSpec], Callable[[Scene, Any], tuple[str, str]]] = {
    AttainablePlot: attainable_plot,
    MinimumGains: minimum_gains,
    Overlay: overlay,
    OverlayPanels: overlay_panels,
    Spectra: spectra,
    ThrustAndLoss: thrust_and_loss,
    SectorPlot: sector_plot,
    ModePlot: mode_plot,
    FaultPlot: fault_plot,
    Bars: bars,
}


def asked_pictures(scene: Scene) -> Iterator[Picture]:
    """Return the pictures that the scenario asks for, in its order."""
    for spec in scene.scenario.plots:
        image, alt = _DRAWN_BY[type(spec)](scene, spec)
        text = " ".join(part for part in (spec.text, f"As {spec.source}." if spec.source else "") if part)
        yield Picture(spec.title, text, image, alt)
