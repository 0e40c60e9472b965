"""What chooses between fixed and rotating thrusters, and what they do, as Figure 6.8 of [Ruth]."""

from __future__ import annotations

import numpy as np

from dp_tools.node_settings import ALLOCATOR
from dp_tools.plot_specs.mode_plot import ModePlot
from dp_tools.report import style
from dp_tools.report.directions import draw_direction
from dp_tools.report.scene import Scene
from marine_model.errors import InputError
from thrust_allocator import AllocatorSettings


def mode_plot(scene: Scene, spec: ModePlot) -> tuple[str, str]:
    """Draw the filtered demand with its hysteresis band, and the directions."""
    run = scene.run
    settings = scene.scenario.settings(scene.vessel)[ALLOCATOR]
    if not isinstance(settings, AllocatorSettings):
        raise InputError(f"{ALLOCATOR}: expected AllocatorSettings, found {type(settings).__name__}")
    auto = settings.auto
    turning = [j for j, can in enumerate(scene.vessel.can_rotate) if can]
    labels = tuple(f"{run.thrusters[j].replace('_', ' ')}\n(deg)" for j in turning)
    panels = scene.panels(("filtered demand\n(N)", *labels), scene.whole, height=1.35)
    low, high = auto.force_limit - auto.hysteresis, auto.force_limit + auto.hysteresis
    panels.band(0, low, high, "hysteresis", style.BAND)
    demand = run["tau_desired"]
    size = np.hypot(demand.values[:, 0], demand.values[:, 1])
    panels.draw(0, demand.t, size, "desired surge-sway force", style.RAW, linewidth=0.6)
    measure = run["performance_measure"]
    panels.draw(0, measure.t, measure.values[:, 0], "filtered", style.COMMANDED, linewidth=1.2)
    words = run.labels["azimuth_mode"]
    held = np.searchsorted(words.t, measure.t + 5e-7, side="right") - 1
    rotating = np.array([words.words[i] == "rotating" for i in held.tolist()])
    panels.stretches(0, measure.t, rotating, "thrusters rotate", style.FLAGGED)
    panels.axes[0].set_ylim(0.0, 1.25 * max(high, float(measure.values.max())))
    for row, j in enumerate(turning, start=1):
        draw_direction(panels, row, scene, j)
    return panels.image(), "Filtered surge-sway demand with its hysteresis band, and thrust directions over time"
