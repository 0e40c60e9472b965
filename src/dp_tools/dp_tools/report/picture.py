"""A stand-alone picture of a run, e.g. for a README."""

from __future__ import annotations

from pathlib import Path

from dp_tools.report import style
from dp_tools.report.panels import Panels
from dp_tools.report.scene import Scene
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario
from dp_tools.signals import total_power, unwrapped_degrees
from marine_model import Vessel

_DPI = 150


def write_picture(run: RunData, scenario: Scenario, vessel: Vessel, path: Path) -> Path:
    """Write position, directions and power of a run as PNG and return ``path``.

    Raises
    ------
    InputError
        If the run lacks a series that is shown.
    """
    scene = Scene(run, scenario, vessel)
    with style.plot_style():
        turning = [j for j, can in enumerate(vessel.can_rotate) if can]
        panels = Panels(
            ("position (m)", "heading (deg)", "directions (deg)", "power (W)"),
            scenario,
            scene.whole,
            height=1.45,
            marked=scene.measured_windows,
            own_legends=True,
        )
        estimate = run["estimate_position"]
        panels.draw(0, estimate.t, estimate.values[:, 0], "north", style.COMMANDED)
        panels.draw(0, estimate.t, estimate.values[:, 1], "east", style.DESIRED)
        panels.at_least(0, 0.2)
        panels.draw(1, estimate.t, unwrapped_degrees(estimate.values[:, 2]), "heading", style.COMMANDED)
        panels.at_least(1, 4.0)
        command = run["azimuth_command"]
        for j in turning:
            name = run.thrusters[j].replace("_", " ")
            color = style.THRUSTERS[j % len(style.THRUSTERS)]
            degrees = unwrapped_degrees(command.values[:, j])
            panels.draw(2, command.t, degrees, name, color, drawstyle="steps-post")
        total = total_power(run)
        panels.draw(3, total.t, total.values[:, 0], "power", style.MEASURED, linewidth=0.8)
        panels.means(3, total, scenario, scene.power_windows, "W")
        panels.headline(scenario.title)
        panels.legends()
        path.parent.mkdir(parents=True, exist_ok=True)
        panels.figure.savefig(path, dpi=_DPI)
    return path
