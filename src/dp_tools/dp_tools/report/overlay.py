"""Windows laid over one another, as Figures 5.9, 5.11 and 5.12 of [Ruth]."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.plot_specs.overlay import Overlay
from dp_tools.report.groups import SINCE_START, lines_of, name_groups
from dp_tools.report.panels import WIDTH, svg_uri
from dp_tools.report.scene import Scene
from dp_tools.run_data import Series
from dp_tools.signals import position_error

_LABELS = {
    "position_error": ("north (m)", "east (m)", "heading (deg)"),
    "force": ("surge (N)", "sway (N)", "yaw (N m)"),
}


def overlay(scene: Scene, spec: Overlay) -> tuple[str, str]:
    """Draw one signal in several windows over the time since each began."""
    signal = _signal(scene, spec.series)
    figure = Canvas(figsize=(WIDTH, 5.4), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True).tolist()
    labels = _LABELS["position_error" if spec.series == "position_error" else "force"]
    for i, (axis, label) in enumerate(zip(axes, labels, strict=True)):
        axis.set_ylabel(label)
        for window, line in lines_of(spec.groups):
            start, end = scene.scenario.windows[window]
            part = signal.window(start, end)
            axis.plot(part.t - start, part.values[:, i], **line)
    name_groups(figure, axes, SINCE_START)
    return svg_uri(figure), f"{spec.series.replace('_', ' ')} in the windows of {', '.join(spec.groups)}"


def _signal(scene: Scene, name: str) -> Series:
    if name != "position_error":
        return scene.run[name]
    error = position_error(scene.run, "estimate_position")
    return Series(error.t, np.column_stack([error.values[:, :2], np.degrees(error.values[:, 2])]))
