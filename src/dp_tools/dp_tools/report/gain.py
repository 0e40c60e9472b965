"""The demand beside the minimum gain, as Figures 7.16, 7.19 and 7.20 of [Ruth]."""

from __future__ import annotations

import numpy as np

from dp_tools.attainable import attainable
from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.report import style
from dp_tools.report.scene import Scene

_STEPS = {"drawstyle": "steps-post"}


def attainable_plot(scene: Scene, spec: AttainablePlot) -> tuple[str, str]:
    """Draw scaled demand, command and minimum gain, and mark where force was missed."""
    span = scene.span(spec.window)
    panels = scene.panels(("scaled force (1)",), span, height=3.2)
    lengths = attainable(scene.run, scene.vessel, spec.reverse)
    t, missed = lengths.t, lengths.missed > spec.tolerance
    panels.draw(0, t, lengths.gain, "minimum gain σ_min", style.LIMIT, linewidth=1.2, **_STEPS)
    panels.draw(0, t, lengths.commanded, "commanded", style.COMMANDED, linewidth=1.0, **_STEPS)
    panels.draw(0, t, lengths.demand, "desired", style.DESIRED, linewidth=1.0, linestyle=(0, (4, 2)), **_STEPS)
    panels.stretches(0, t, missed & lengths.beyond, "missed: beyond σ_min", style.RAW)
    panels.stretches(0, t, missed & lengths.too_fast, "faster than thrust", style.MEASURED)
    panels.stretches(0, t, missed & lengths.inside, "within σ_min", style.FLAGGED)
    panels.axes[0].set_ylim(bottom=0.0)
    return panels.image(), "Length of the scaled desired and commanded force and the minimum gain over time"


def minimum_gains(scene: Scene, spec: MinimumGains) -> tuple[str, str]:
    """Draw the minimum gains with and without singularity avoidance."""
    span = scene.span(spec.window)
    panels = scene.panels(("minimum gain (1)",), span, height=2.6)
    run = scene.run
    if "minimum_gain_free" in run:
        free = run["minimum_gain_free"]
        known = np.isfinite(free.values[:, 0])
        if known.any():
            panels.draw(0, free.t, free.values[:, 0], "first step: free", style.MEASURED, linewidth=1.2, **_STEPS)
    commanded = run["minimum_gain_both_ways"]
    label = "as commanded, thrusters pushing both ways"
    panels.draw(0, commanded.t, commanded.values[:, 0], label, style.COMMANDED, linewidth=1.0, **_STEPS)
    if spec.push:
        push = run["minimum_gain"]
        panels.draw(0, push.t, push.values[:, 0], "rotating thrusters one way", style.DESIRED, linewidth=1.0, **_STEPS)
    if spec.limit is not None:
        panels.level(0, spec.limit, "σ_lim")
    panels.axes[0].set_ylim(bottom=0.0)
    return panels.image(), "Minimum gain over time: as commanded, and without singularity avoidance"
