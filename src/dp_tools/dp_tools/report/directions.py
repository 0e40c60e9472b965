"""One panel with the direction of one thruster."""

from __future__ import annotations

import numpy as np

from dp_tools.report import style
from dp_tools.report.panels import Panels
from dp_tools.report.scene import Scene
from dp_tools.report.thinning import break_turns
from marine_model.frames import wrap_angles


def draw_direction(panels: Panels, row: int, scene: Scene, j: int) -> None:
    """Draw measured and commanded direction of thruster ``j``, deg, within half a turn of 0."""
    command = scene.run["azimuth_command"]
    if "azimuth" in scene.run:
        measured = scene.run["azimuth"]
        # On the same side of 180 deg as the command, or noise would draw lines across the whole panel.
        held = command.at(measured.t)[:, j]
        near = held + wrap_angles(measured.values[:, j] - held)
        panels.draw(row, measured.t, break_turns(np.degrees(near)), "measured", style.MEASURED, linewidth=1.6)
    panels.draw(
        row,
        command.t,
        break_turns(np.degrees(command.values[:, j])),
        "commanded",
        style.COMMANDED,
        linewidth=0.9,
        drawstyle="steps-post",
    )
    panels.axes[row].set_ylim(-190.0, 190.0)
    panels.axes[row].set_yticks([-180, -90, 0, 90, 180])
