"""Sub-problem and thrust directions over the forbidden sectors, as Figure 6.5 of [Ruth]."""

from __future__ import annotations

import math

import numpy as np

from dp_tools.plot_specs.sector_plot import SectorPlot
from dp_tools.report import style
from dp_tools.report.directions import draw_direction
from dp_tools.report.panels import Panels
from dp_tools.report.scene import Scene
from marine_model.sector import Sector


def sector_plot(scene: Scene, spec: SectorPlot) -> tuple[str, str]:
    """Draw the sub-problem and, thruster by thruster, directions over shaded sectors."""
    run, vessel = scene.run, scene.vessel
    span = scene.span(spec.window)
    turning = [j for j, sectors in enumerate(vessel.sectors) if sectors]
    labels = tuple(f"{run.thrusters[j].replace('_', ' ')}\n(deg)" for j in turning)
    panels = Panels(("sub-problem", *labels), scene.scenario, span, height=1.35)
    chosen = run["sub_problem"]
    panels.draw(0, chosen.t, chosen.values[:, 0], "sub-problem", style.DESIRED, linewidth=1.0, drawstyle="steps-post")
    panels.axes[0].set_ylim(0.0, float(np.nanmax(chosen.values)) + 1.0)
    for row, j in enumerate(turning, start=1):
        for sector in vessel.sectors[j]:
            _shade(panels, row, sector)
        draw_direction(panels, row, scene, j)
    return panels.image(), "Chosen sub-problem and thrust directions over time, forbidden sectors shaded"


def _shade(panels: Panels, row: int, sector: Sector) -> None:
    start = math.degrees(sector.start)
    end = start + math.degrees(sector.width)
    label = "forbidden" if sector.kind == "forbidden" else "reduced"
    for turn in (0.0, -360.0):  # a sector through 180 deg is seen at both ends of the axis
        panels.band(row, start + turn, end + turn, label, style.FAULT if label == "forbidden" else style.WINDOWS[1])
