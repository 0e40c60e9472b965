"""Thrusts with torque losses, as Figures 5.2 and 5.5 of [Ruth]."""

from __future__ import annotations

import numpy as np

from dp_tools.plot_specs.thrust_and_loss import ThrustAndLoss
from dp_tools.report import style
from dp_tools.report.panels import Panels
from dp_tools.report.scene import Scene
from dp_tools.report.thinning import thin
from dp_tools.run_data import Series
from dp_tools.scenario import Scenario

_RIGHT = 0.5  # inch, margin for the numbers of the second axis
# A panel shows at least this much, N: a thruster at rest should look at rest.
_THRUST_HEIGHT = 0.5
_NODE, _SWITCH = "thrust_allocator", "antispin.enabled"


def thrust_and_loss(scene: Scene, spec: ThrustAndLoss) -> tuple[str, str]:
    """Draw commanded thrusts (left) and what the drivers remember of losses (right)."""
    run = scene.run
    span = scene.span(spec.window)
    labels = tuple(f"{name.replace('_', ' ')}\n(N)" for name in run.thrusters)
    panels = Panels(labels, scene.scenario, span, 1.4, scene.measured_windows, right=_RIGHT)
    command, losses = run["thrust_command"], run["beta_q2"]
    for j, axis in enumerate(panels.axes):
        panels.draw(j, command.t, command.values[:, j], "commanded thrust (left)", style.COMMANDED, linewidth=0.9)
        panels.at_least(j, _THRUST_HEIGHT)
        second, label, color = losses, "β_Q2 (right)", style.DESIRED
        if j == 0:
            second, label, color = (
                antispin_flag(scene.scenario, scene.run.duration),
                "anti-spin on (right)",
                style.LIMIT,
            )
        values = second.values[:, min(j, second.values.shape[1] - 1)]
        inside = (second.t >= span[0] - 1e-6) & (second.t <= span[1] + 1e-6)
        if j == 0:
            inside = np.ones(len(second.t), dtype=bool)  # corners of a step function, some before the window
        right = axis.twinx()
        right.grid(visible=False)
        right.set_ylim(0.0, 1.1)
        right.set_yticks([0.0, 0.5, 1.0])
        right.set_xlim(*span)
        style_of = "steps-post" if j == 0 else "default"
        (line,) = right.plot(*thin(second.t[inside], values[inside]), color=color, linewidth=1.0, drawstyle=style_of)
        panels.add_to_legend(j, label, line)
    return panels.image(), "Commanded thrust and torque loss factor of every thruster over time"


def antispin_flag(scenario: Scenario, duration: float) -> Series:
    """Return 1 while the scenario has anti-spin allocation on, as corners of a step function, shape (k, 1)."""
    state = float(bool(scenario.parameters.get(_NODE, {}).get(_SWITCH, False)))
    corners = [(0.0, state)]
    for event in scenario.events:
        if _SWITCH in event.parameters.get(_NODE, {}):
            state = float(bool(event.parameters[_NODE][_SWITCH]))
            corners.append((event.at, state))
    corners.append((max(duration, corners[-1][0]), state))
    table = np.array(corners)
    return Series(table[:, 0], table[:, 1:])
