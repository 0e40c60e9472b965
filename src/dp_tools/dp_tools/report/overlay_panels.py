"""Windows laid over one another, one signal a panel, as Figures 5.10, C.8 and C.9 of [Ruth]."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.plot_specs.overlay_panels import OverlayPanels, Panel
from dp_tools.report.groups import SINCE_START, lines_of, name_groups
from dp_tools.report.panels import WIDTH, svg_uri
from dp_tools.report.scene import Scene
from dp_tools.report.thinning import break_turns, thin
from dp_tools.run_data import Series
from dp_tools.signals import averaged, total_power

_LABELS = {
    "total_power": "total power (W)",
    "thrust_command": "thrust (N)",
    "azimuth_command": "direction (deg)",
    "beta_q2": "β_Q2 (1)",
}


def overlay_panels(scene: Scene, spec: OverlayPanels) -> tuple[str, str]:
    """Draw one signal a panel in several windows over the time since each began."""
    count = len(spec.panels)
    figure = Canvas(figsize=(WIDTH, 0.8 + 1.5 * count), layout="constrained")
    axes = np.atleast_1d(figure.subplots(count, 1, sharex=True)).tolist()
    for axis, panel in zip(axes, spec.panels, strict=True):
        signal = _signal(scene, panel)
        name = panel.thruster.replace("_", " ")
        axis.set_ylabel(f"{name}\n{_LABELS[panel.series]}" if name else _LABELS[panel.series])
        for window, line in lines_of(spec.groups):
            start, end = scene.scenario.windows[window]
            part = signal.window(start, end)
            values = part.values[:, 0]
            if panel.series == "azimuth_command":
                values = break_turns(values)
            axis.plot(*thin(part.t - start, values), **line)
        if panel.series == "beta_q2":
            axis.set_ylim(0.0, 1.1)
        elif panel.series == "azimuth_command":
            axis.set_ylim(-190.0, 190.0)
            axis.set_yticks([-180, -90, 0, 90, 180])
    name_groups(figure, axes, SINCE_START)
    shown = ", ".join(f"{_LABELS[panel.series]} {panel.thruster}".strip() for panel in spec.panels)
    return svg_uri(figure), f"{shown} in the windows of {', '.join(spec.groups)}"


def _signal(scene: Scene, panel: Panel) -> Series:
    """Return what a panel shows as one column; power as means over samples of the control system."""
    run = scene.run
    if panel.series == "total_power":
        return averaged(total_power(run), scene.vessel.measurement.sample_time)
    series, j = run[panel.series], run.thrusters.index(panel.thruster)
    values = series.values[:, j : j + 1]
    return Series(series.t, np.degrees(values) if panel.series == "azimuth_command" else values)
