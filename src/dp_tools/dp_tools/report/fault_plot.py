"""Position and faulty thrusters, as Figures 6.10 and 6.13 of [Ruth]."""

from __future__ import annotations

import numpy as np

from dp_tools.plot_specs.fault_plot import FaultPlot
from dp_tools.report import style
from dp_tools.report.scene import Scene
from dp_tools.signals import unwrapped_degrees

_LABELS = ("north (m)", "east (m)", "heading (deg)", "faulty")


def fault_plot(scene: Scene, spec: FaultPlot) -> tuple[str, str]:
    """Draw estimate and reference, and a row a thruster that is red while it is faulty, with the configuration."""
    run = scene.run
    panels = scene.panels(_LABELS, scene.whole, height=1.35)
    for name, label, color, line in (
        ("estimate_position", "estimate", style.COMMANDED, {"linewidth": 1.0}),
        ("reference_position", "reference", style.DESIRED, {"linestyle": (0, (5, 2))}),
    ):
        series = run[name]
        for i in range(3):
            values = series.values[:, i]
            panels.draw(i, series.t, unwrapped_degrees(values) if i == 2 else values, label, color, **line)
    axis = panels.axes[3]
    n = len(run.thrusters)
    for fault in scene.faults:
        for j, (motor, azimuth) in enumerate(zip(fault.motors, fault.azimuths, strict=True)):
            if motor or azimuth:
                color = style.DESIRED if motor else style.LIMIT
                axis.broken_barh([(fault.start, fault.end - fault.start)], (j + 0.6, 0.8), color=color, zorder=3)
        # The names of thrusters that work, as the thesis calls a case.
        panels.axes[0].annotate(
            fault.name,
            (0.5 * (fault.start + fault.end), 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -3),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=8.0,
            fontweight="bold",
            color=style.INK,
        )
    axis.set_ylim(n + 0.8, 0.2)
    axis.set_yticks(np.arange(1, n + 1))
    axis.grid(visible=False)
    for i, height in enumerate((0.05, 0.05, 1.0)):
        panels.at_least(i, height)
    return panels.image(), "Position and heading over time, and which thrusters are faulty when"
