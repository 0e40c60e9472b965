"""Pictures of submerged vehicles: depth, roll, pitch, forces along other axes, and what an allocation method did."""

from __future__ import annotations

from typing import Any

import numpy as np

from dp_tools.report import style
from dp_tools.report.scene import Picture, Scene, Span
from dp_tools.run_data import Series
from dp_tools.signals import measured_vertical_force
from marine_model.axes import FORCE_UNITS, HORIZONTAL, VERTICAL, axis_indices

_LABELS = ("depth (m)", "roll (deg)", "pitch (deg)")
# A panel shows at least this much, m, deg, deg.
_HEIGHTS = (0.05, 1.0, 1.0)


def below(scene: Scene, span: Span) -> Picture:
    """Depth, roll and pitch."""
    run = scene.run
    panels = scene.panels(_LABELS, span, height=1.45)
    lines: list[tuple[str, str, str, dict[str, Any]]] = [
        ("vertical_pose", "measured", style.RAW, {"linewidth": 0.7}),
        ("vertical_truth", "true", style.MEASURED, {"linewidth": 1.8}),
        ("vertical_estimate", "estimate", style.COMMANDED, {"linewidth": 1.0}),
        ("vertical_reference", "reference", style.DESIRED, {"linestyle": (0, (5, 2))}),
    ]
    controlled = [axis in scene.vessel.degrees_of_freedom for axis in VERTICAL]
    for name, label, color, line in lines:
        if name not in run:
            continue
        series = run[name]
        for i in range(3):
            if name == "vertical_reference" and not controlled[i]:
                continue
            values = series.values[:, i]
            panels.draw(i, series.t, values if i == 0 else np.degrees(values), label, color, **line)
    for i, height in enumerate(_HEIGHTS):
        panels.at_least(i, height)
    panels.axes[0].invert_yaxis()
    return Picture(
        "Depth, roll and pitch",
        "Depth grows downwards. What the vehicle does not control has no reference: it stays upright by itself.",
        panels.image(),
        "Depth, roll and pitch over time: measured, true, estimated and reference",
    )


def vertical_forces(scene: Scene, span: Span) -> Picture:
    """Generalized force along the axes beside surge, sway and yaw."""
    run, vessel = scene.run, scene.vessel
    shown = [i for i, axis in enumerate(VERTICAL) if axis in vessel.degrees_of_freedom]
    units = [FORCE_UNITS[index] for index in axis_indices(VERTICAL)]
    panels = scene.panels(tuple(f"{VERTICAL[i]} ({units[i]})" for i in shown), span)
    series: list[tuple[Series, str, str, dict[str, Any]]] = []
    if "shaft_speed" in run and "azimuth" in run:
        series.append((measured_vertical_force(run, vessel), "measured", style.MEASURED, {"linewidth": 0.8}))
    steps = {"drawstyle": "steps-post"}
    series.append((run["vertical_achieved"], "commanded", style.COMMANDED, steps))
    series.append((run["vertical_desired"], "desired", style.DESIRED, steps | {"linestyle": (0, (4, 2))}))
    for one, label, color, line in series:
        for row, i in enumerate(shown):
            panels.draw(row, one.t, one.values[:, i], label, color, **line)
    for row in range(len(shown)):
        panels.at_least(row, 0.5)
    return Picture(
        "Generalized forces along the other axes",
        "Desired by the controller, commanded by the allocator, and worked out from measured shaft speeds as for a "
        "vehicle that stands still.",
        panels.image(),
        "Generalized force along heave, roll or pitch over time: desired, commanded, measured",
    )


def method(scene: Scene, span: Span) -> Picture:
    """What the allocation method made of the demands, and what the quadratic program would have achieved."""
    run, axes = scene.run, scene.vessel.degrees_of_freedom
    units = [FORCE_UNITS[index] for index in axis_indices(axes)]
    labels = [f"{axis} ({unit})" for axis, unit in zip(axes, units, strict=True)]
    panels = scene.panels((*labels, "load (1)"), span, height=1.3)
    steps = {"drawstyle": "steps-post"}
    desired = dict(zip(HORIZONTAL, run["tau_desired"].values.T, strict=True))
    desired |= dict(zip(VERTICAL, run["vertical_desired"].values.T, strict=True)) if "vertical_desired" in run else {}
    for row, axis in enumerate(axes):
        panels.draw(row, run["tau_desired"].t, desired[axis], "desired", style.DESIRED, linestyle=(0, (4, 2)), **steps)
        for name, label, color in (
            ("tau_qp", "attained by the quadratic program", style.MEASURED),
            ("tau_feasible", "left by the method", style.COMMANDED),
        ):
            if name in run:
                panels.draw(row, run[name].t, run[name].values[:, row], label, color, **steps)
        panels.at_least(row, 0.5)
    load = run["feasible_load"]
    panels.draw(len(axes), load.t, load.values[:, 0], "load on the method's region", style.LIMIT, **steps)
    panels.level(len(axes), 1.0, "edge")
    return Picture(
        "Allocation method",
        "Demands, what the method in force reduced them to, and what the constrained quadratic program would have "
        "achieved for the same demand from the same operating point. Last: the demand on the region that the method "
        "takes for attainable, whose edge is 1.",
        panels.image(),
        "Desired, feasible and attainable generalized force by axis over time, and load on the feasible region",
    )


def codes(scene: Scene, span: Span) -> Picture:
    """Codes of torque-controlled drives."""
    run = scene.run
    coded = [j for j in range(len(run.thrusters)) if run["code"].values[:, j].any()]
    panels = scene.panels(tuple(f"{run.thrusters[j].replace('_', ' ')}\n(code)" for j in coded), span, height=1.1)
    for row, j in enumerate(coded):
        panels.draw(row, run["code"].t, run["code"].values[:, j], "asked", style.COMMANDED, drawstyle="steps-post")
        panels.at_least(row, 4.0)
    return Picture(
        "Codes of the drives",
        "Whole numbers from -127 to 127 that torque-controlled drives are asked for.",
        panels.image(),
        "Code of every drive over time",
    )
