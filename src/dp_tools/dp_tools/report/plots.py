"""The pictures of a report, in the manner of Figures 4.5-4.9 and C.1-C.3 of [Ruth]."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.report import style
from dp_tools.report.directions import draw_direction
from dp_tools.report.panels import svg_uri
from dp_tools.report.scene import Picture, Scene, Span
from dp_tools.report.underwater import below, codes, method, vertical_forces
from dp_tools.run_data import Series
from dp_tools.signals import (
    averaged,
    low_frequency_truth,
    measured_force,
    measured_thrust,
    total_power,
    unwrapped_degrees,
)

_FORCE_LABELS = ("surge (N)", "sway (N)", "yaw (N m)")
_PLACE_LABELS = ("north (m)", "east (m)", "heading (deg)")
# A panel shows at least this much, m, m, deg: a quiet vessel should look quiet.
_PLACE_HEIGHTS = (0.05, 0.05, 1.0)


def pictures(scene: Scene) -> Iterator[Picture]:
    """Return the pictures of the whole run; what the run has no signals for is left out."""
    makers: tuple[tuple[tuple[str, ...], Callable[[Scene, Span], Picture]], ...] = (
        (("estimate_position",), position),
        (("vertical_estimate",), below),
        (("power",), power),
        (("tau_desired", "tau_achieved"), forces),
        (("vertical_desired", "vertical_achieved"), vertical_forces),
        (("feasible_load", "tau_desired"), method),
        (("azimuth_command",), directions),
        (("thrust_command",), thrusts),
        (("code",), codes),
        (("beta_q2", "thrust_command"), ventilation),
        (("estimate_position",), track),
        (("wave_position", "bias"), observer),
        (("proportional", "integral", "derivative"), control_terms),
    )
    for needed, maker in makers:
        if not all(name in scene.run for name in needed):
            continue
        if (maker is control_terms and not scene.automatic) or (maker is directions and not any(_turning(scene))):
            continue
        yield maker(scene, scene.whole)


def close_up_pictures(scene: Scene, window: str) -> Iterator[Picture]:
    """Return forces, directions and thrusts of one window."""
    span = scene.scenario.windows[window]
    for needed, maker in (
        ("vertical_estimate", below),
        ("tau_desired", forces),
        ("feasible_load", method),
        ("azimuth_command", directions),
        ("thrust_command", thrusts),
        ("beta_q2", ventilation),
        ("power", power),
    ):
        if needed in scene.run and (maker is not directions or any(_turning(scene))):
            yield maker(scene, span)


def _turning(scene: Scene) -> tuple[bool, ...]:
    """Return which thrusters turn."""
    return scene.vessel.can_rotate


def position(scene: Scene, span: Span) -> Picture:
    """Position and heading, Figure 4.5."""
    run = scene.run
    panels = scene.panels(_PLACE_LABELS, span, height=1.55)
    lines: list[tuple[Series, str, str, dict[str, Any]]] = []
    if "pose" in run:
        lines.append((run["pose"], "measured, with wave motion", style.RAW, {"linewidth": 0.7}))
    if "truth_position" in run:
        truth = low_frequency_truth(run, scene.vessel)
        lines.append((truth, "true, wave motion filtered out", style.MEASURED, {"linewidth": 1.8}))
    lines.append((run["estimate_position"], "estimate", style.COMMANDED, {"linewidth": 1.0}))
    if "reference_position" in run and scene.automatic:
        lines.append((run["reference_position"], "reference", style.DESIRED, {"linestyle": (0, (5, 2))}))
    for series, label, color, line in lines:
        for i in range(3):
            values = series.values[:, i]
            panels.draw(i, series.t, unwrapped_degrees(values) if i == 2 else values, label, color, **line)
    for i, height in enumerate(_PLACE_HEIGHTS):
        panels.at_least(i, height)
    return Picture(
        "Position and heading",
        "The observer's low-frequency estimate should follow the true motion and leave the wave motion out. "
        "The true motion is shown through a filter without delay.",
        panels.image(),
        "North, east and heading over time: measured, true, estimated and reference",
    )


def power(scene: Scene, span: Span) -> Picture:
    """Developed power, total and by thruster, Figure 4.6."""
    run = scene.run
    panels = scene.panels(("total (W)", "by thruster (W)"), span, height=1.9, own_legends=True)
    total = total_power(run)
    panels.draw(0, total.t, total.values[:, 0], "developed power", style.MEASURED, linewidth=0.8)
    if "thrust_command" in run:
        command = run["thrust_command"]
        demanded = scene.vessel.propellers.power(command.values).sum(axis=1)
        panels.draw(0, command.t, demanded, "of the commanded thrusts", style.COMMANDED, linewidth=0.9)
    panels.means(0, total, scene.scenario, scene.power_windows, "W")
    by_thruster = averaged(run["power"], scene.vessel.measurement.sample_time)
    for j, name in enumerate(run.thrusters):
        panels.draw(
            1,
            by_thruster.t,
            by_thruster.values[:, j],
            name.replace("_", " "),
            style.THRUSTERS[j % len(style.THRUSTERS)],
            linewidth=0.8,
        )
    return Picture(
        "Power",
        "Developed power 2 π n Q from measured shaft speed n and motor torque Q; it is negative while a propeller is "
        "braked. By thruster: averaged over samples of the control system, so that sensor noise does not hide one "
        "behind another.",
        panels.image(),
        "Developed power over time, total and by thruster",
    )


def forces(scene: Scene, span: Span) -> Picture:
    """Generalized force: desired, commanded, measured; Figures 4.7 and C.1."""
    run = scene.run
    panels = scene.panels(_FORCE_LABELS, span)
    if "shaft_speed" in run and "azimuth" in run:
        measured = measured_force(run, scene.vessel)
        for i in range(3):
            panels.draw(i, measured.t, measured.values[:, i], "measured", style.MEASURED, linewidth=0.8)
    for name, label, color, line in (
        ("tau_achieved", "commanded", style.COMMANDED, {"drawstyle": "steps-post"}),
        (
            "tau_desired",
            "desired",
            style.DESIRED,
            {"linestyle": (0, (4, 2)), "linewidth": 1.0, "drawstyle": "steps-post"},
        ),
    ):
        if name in run:
            for i in range(3):
                panels.draw(i, run[name].t, run[name].values[:, i], label, color, **line)
    for i in range(3):
        panels.at_least(i, 0.5)
    return Picture(
        "Generalized forces",
        "Desired by the controller, commanded by the allocator, and measured: worked out from measured shaft speeds "
        "and azimuth angles (τ_RAW in the thesis), sensor noise included.",
        panels.image(),
        "Generalized force in surge, sway and yaw over time: desired, commanded, measured",
    )


def directions(scene: Scene, span: Span) -> Picture:
    """Directions of the azimuth thrusters, Figures 4.8 and C.2."""
    run = scene.run
    turning = [j for j, can in enumerate(_turning(scene)) if can]
    panels = scene.panels(tuple(f"{run.thrusters[j].replace('_', ' ')}\n(deg)" for j in turning), span, height=1.35)
    for row, j in enumerate(turning):
        draw_direction(panels, row, scene, j)
    return Picture(
        "Thrust directions",
        "Direction of the thruster force: 0° ahead, 90° to starboard. Lines are broken where an angle passes ±180°.",
        panels.image(),
        "Directions of the azimuth thrusters over time: commanded and measured",
    )


def thrusts(scene: Scene, span: Span) -> Picture:
    """Thrusts, Figures 4.9 and C.3."""
    run, vessel = scene.run, scene.vessel
    panels = scene.panels(tuple(f"{name.replace('_', ' ')}\n(N)" for name in run.thrusters), span, height=1.3)
    for j in range(len(run.thrusters)):
        if "shaft_speed" in run:
            measured = measured_thrust(run, vessel)
            panels.draw(j, measured.t, measured.values[:, j], "from shaft speed", style.MEASURED, linewidth=0.8)
        if "truth_thrust" in run:
            truth = run["truth_thrust"]
            panels.draw(j, truth.t, truth.values[:, j], "true", style.RAW, linewidth=0.6)
        command = run["thrust_command"]
        panels.draw(
            j,
            command.t,
            command.values[:, j],
            "commanded",
            style.COMMANDED,
            linewidth=0.9,
            drawstyle="steps-post",
        )
        low, high = panels.axes[j].get_ylim()
        span_of_axis = high - low
        # A limit far outside of what was used would only flatten the curve.
        for limit in (float(vessel.thrust_min[j]), float(vessel.thrust_max[j])):
            if low - 0.4 * span_of_axis <= limit <= high + 0.4 * span_of_axis:
                panels.level(j, limit, "limit")
    return Picture(
        "Thruster forces",
        "Thrust along the direction of each thruster: commanded, what the measured shaft speed stands for in still "
        "water, and true, with what waves, current and air take. Limits are drawn where a thruster came near them.",
        panels.image(),
        "Thrust of every thruster over time: commanded, from shaft speed, true",
    )


def ventilation(scene: Scene, span: Span) -> Picture:
    """Torque loss factors, Figures 5.2 and 5.5: of thrusters that ventilated at any time, or else of all."""
    run = scene.run
    ventilated = np.flatnonzero(run["ventilating"].values.any(axis=0)).tolist() or list(range(len(run.thrusters)))
    panels = scene.panels(tuple(f"{run.thrusters[j].replace('_', ' ')}\n(1)" for j in ventilated), span, height=1.3)
    for row, j in enumerate(ventilated):
        for name, label, color, line in (
            ("truth_torque_loss", "true", style.DESIRED, {"linewidth": 0.8}),
            ("beta_q", "observed", style.RAW, {"linewidth": 0.6}),
            ("beta_q2", "remembered", style.MEASURED, {"linewidth": 1.2}),
            ("torque_loss", "used by the allocator", style.COMMANDED, {"linewidth": 1.0, "drawstyle": "steps-post"}),
        ):
            if name in run:
                panels.draw(row, run[name].t, run[name].values[:, j], label, color, **line)
        panels.stretches(row, run["ventilating"].t, run["ventilating"].values[:, j] > 0.5, "flagged", style.FLAGGED)
        panels.axes[row].set_ylim(0.0, 1.4)
    return Picture(
        "Ventilation: torque loss factors",
        "True loss to air, once a sample of the control system; observed propeller torque over that of a propeller "
        "without loss in still water (β_Q; waves move it about 1 as well); what is remembered of it while a thruster "
        "ventilates (β_Q2), and what raises its cost in the allocator. Bars at the foot: flagged as ventilating.",
        panels.image(),
        "Torque loss factors of ventilating thrusters over time",
    )


def track(scene: Scene, span: Span) -> Picture:
    """Where the vessel went, seen from above."""
    run = scene.run
    figure = Canvas(figsize=(5.6, 5.2), layout="constrained")
    axis = figure.subplots()
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.06)
    estimate = run["estimate_position"]
    parts = [
        (name, estimate.window(*scene.scenario.windows[name]), style.WINDOW_EDGES[i % len(style.WINDOW_EDGES)])
        for i, name in enumerate(scene.measured_windows)
    ]
    parts = [entry for entry in parts if len(entry[1].t)] or [("whole run", estimate, style.COMMANDED)]
    farthest = max(float(np.abs(part.values[:, :2]).max()) for _, part, _ in parts)
    scale, unit = (1000.0, "mm") if farthest < 0.1 else (1.0, "m")
    for name, part, color in parts:
        place = scale * part.values
        # A shorter part over a longer one, which may hold it.
        height = 3.0 - len(part.t) / len(estimate.t)
        axis.plot(place[:, 1], place[:, 0], color=color, linewidth=1.0, label=name, zorder=height)
        axis.plot(place[0, 1], place[0, 0], marker="o", markersize=4.5, color=color, zorder=3.0)
    axis.set_xlabel(f"east ({unit})")
    axis.set_ylabel(f"north ({unit})")
    figure.legend(loc="outside upper right", ncols=4)
    return Picture(
        "Track",
        "Low-frequency estimate of the position, seen from above; a dot marks where each part begins.",
        svg_uri(figure),
        "Track of the vessel in the plane",
        narrow=True,
    )


def observer(scene: Scene, span: Span) -> Picture:
    """What the observer's wave filter and bias model hold."""
    run = scene.run
    panels = scene.panels(("wave motion\nnorth (m)", "bias north, east\n(N)", "bias yaw\n(N m)"), span, height=1.4)
    wave, bias = run["wave_position"], run["bias"]
    panels.draw(0, wave.t, wave.values[:, 0], "wave-frequency part", style.MEASURED, linewidth=0.7)
    panels.draw(1, bias.t, bias.values[:, 0], "bias north", style.COMMANDED)
    panels.draw(1, bias.t, bias.values[:, 1], "bias east", style.DESIRED)
    panels.draw(2, bias.t, bias.values[:, 2], "bias yaw", style.LIMIT)
    return Picture(
        "Observer: wave filter and bias",
        "What the observer takes for wave motion, and the slowly varying environmental force it infers (in the map "
        "frame).",
        panels.image(),
        "Wave-frequency estimate and bias estimate over time",
    )


def control_terms(scene: Scene, span: Span) -> Picture:
    """Terms of the controller."""
    run = scene.run
    panels = scene.panels(_FORCE_LABELS, span, height=1.4)
    for name, color in (
        ("derivative", style.MEASURED),
        ("proportional", style.COMMANDED),
        ("integral", style.DESIRED),
    ):
        for i in range(3):
            panels.draw(i, run[name].t, run[name].values[:, i], name, color, linewidth=1.0)
    if "wind_feedforward" in run and run["wind_feedforward"].values.any():
        term = run["wind_feedforward"]
        for i in range(3):
            panels.draw(i, term.t, term.values[:, i], "wind feed-forward", style.LIMIT, linewidth=1.0)
    for i in range(3):
        panels.at_least(i, 0.5)
    return Picture(
        "Controller: proportional, integral and derivative terms",
        "With wind feed-forward, joystick and the fading part of a switch of modes they add up to the desired "
        "generalized force, before limits. The integral term settles at what balances the environment.",
        panels.image(),
        "Proportional, integral and derivative terms in surge, sway and yaw over time",
    )
