"""Figures of merit as bars."""

from __future__ import annotations

from matplotlib.figure import Figure as Canvas

from dp_tools.figures import compute_figures
from dp_tools.plot_specs.bars import Bars
from dp_tools.report import style
from dp_tools.report.panels import WIDTH, svg_uri
from dp_tools.report.scene import Scene


def bars(scene: Scene, spec: Bars) -> tuple[str, str]:
    """Draw the figures named side by side."""
    known = {figure.name: figure for figure in scene.scenario.figures}
    asked = scene.scenario.model_copy(update={"figures": tuple(known[name] for name in spec.figures)})
    found = compute_figures(scene.run, asked, scene.vessel)
    figure = Canvas(figsize=(WIDTH, 2.9), layout="constrained")
    axis = figure.subplots()
    names = [name.rpartition("_")[2] for name in spec.figures]
    values = [entry.value if entry.value is not None else 0.0 for entry in found]
    drawn = axis.bar(range(len(names)), values, color=style.COMMANDED, width=0.6, zorder=3)
    axis.bar_label(drawn, labels=[f"{value:.3g}" for value in values], padding=2, fontsize=8.0)
    axis.set_xticks(range(len(names)), names)
    axis.set_ylabel(spec.label)
    if spec.logarithmic:
        axis.set_yscale("log")
    if spec.level is not None:
        axis.axhline(spec.level, color=style.DESIRED, linewidth=1.0, linestyle=(0, (4, 2)))
    axis.margins(y=0.15)
    return svg_uri(figure), f"{spec.label or spec.title} of {', '.join(names)}"
