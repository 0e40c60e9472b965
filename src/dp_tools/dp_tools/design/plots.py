"""Figures of `dp design`: minimum gain of every combination, the attainable set, maps of the minimum gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from dp_tools.design.tables import numbers
from dp_tools.report import style
from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.attainable import AXES, force_set, projection, section
from thrust_allocator.design.loop import Study
from thrust_allocator.design.maps import GainMap, MapCase

_DPI = 130
# Even steps look even, in grey too, and to colour-blind readers.
_COLOURS = "viridis"
_LABELS = dict(zip(AXES, ("surge (N)", "sway (N)", "yaw (N m)"), strict=True))
_METHODS = {"svd": "", "theorem_7_1": "Theorem 7.1", "theorem_7_2": "Theorem 7.2"}


def draw_gains(vessel: Vessel, found: Study, path: Path) -> None:
    """Draw the minimum gain of every combination that can produce every force, freely rotating."""
    rows = [row for row in found.combinations if row.gain > 0.0 or row.equal_gain > 0.0][::-1]
    with style.plot_style():
        figure = Figure(figsize=(6.4, 1.2 + 0.26 * len(rows)), layout="constrained")
        axis = figure.subplots()
        place = np.arange(len(rows))
        own, equal = [row.gain for row in rows], [row.equal_gain for row in rows]
        axis.barh(place + 0.19, own, height=0.36, color=style.COMMANDED, label="own thrusts")
        axis.barh(place - 0.19, equal, height=0.36, color=style.MEASURED, label="equal thrusts")
        axis.set_yticks(place, [numbers(row.thrusters) for row in rows])
        axis.set_xlabel("minimum gain (1)")
        axis.set_ylabel("working thrusters")
        axis.grid(visible=False, axis="y")
        axis.set_title(f"{vessel.name}: minimum gain, freely rotating", fontsize=10.0)
        figure.legend(loc="outside lower center", ncols=2)
        figure.savefig(path, dpi=_DPI)


def draw_attainable(vessel: Vessel, found: Study, azimuth: FloatArray, path: Path) -> None:
    """Draw sections and shadows of the attainable set, freely rotating and at given directions."""
    sets = (
        (force_set(vessel), style.COMMANDED, "freely rotating"),
        (force_set(vessel, azimuth), style.DESIRED, f"fixed at {_degrees(azimuth)}"),
    )
    with style.plot_style():
        figure = Figure(figsize=(10.6, 4.1), layout="constrained")
        for axis, pair in zip(figure.subplots(1, 3), (AXES[:2], (AXES[0], AXES[2]), AXES[1:]), strict=True):
            for forces, color, label in sets:
                shadow, cut = projection(forces, *pair, points=720), section(forces, *pair, points=720)
                axis.plot(
                    *_closed(shadow), color=color, linestyle=(0, (4, 2)), label=f"{label}, any force on the third axis"
                )
                axis.fill(*cut.T, color=color, alpha=0.13, linewidth=0.0)
                axis.plot(*_closed(cut), color=color, label=f"{label}, none on the third axis")
            turn = np.linspace(0.0, 2.0 * math.pi, 181)
            axis.plot(
                found.ball.exact * np.cos(turn),
                found.ball.exact * np.sin(turn),
                color=style.LIMIT,
                linewidth=0.9,
                label=f"largest ball, freely rotating, {found.ball.exact:.1f} N, N m",
            )
            axis.margins(0.06)
            axis.set_xlabel(_LABELS[pair[0]])
            axis.set_ylabel(_LABELS[pair[1]])
        lines, labels = axis.get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower center", ncols=3)
        figure.suptitle(f"{vessel.name}: attainable generalized forces", fontsize=10.0)
        figure.savefig(path, dpi=_DPI)


def draw_map(vessel: Vessel, one: GainMap, path: Path) -> None:
    """Draw one map, with colours of its own scale."""
    with style.plot_style():
        figure = Figure(figsize=(5.6, 4.9), layout="constrained")
        axis = figure.subplots()
        mesh = _map(axis, vessel, one, float(one.gain.max()), labels=True)
        axis.set_title("\n".join([vessel.name, *_title(vessel, one.case)]), fontsize=9.0)
        figure.colorbar(mesh, ax=axis, label="minimum gain (1)")
        figure.savefig(path, dpi=_DPI)


def draw_overview(vessel: Vessel, maps: Sequence[GainMap], path: Path) -> None:
    """Draw all maps on one sheet with one scale of colours."""
    columns = min(5 if len(maps) > 8 else 4, len(maps))
    rows = -(-len(maps) // columns)
    highest = max(float(one.gain.max()) for one in maps)
    with style.plot_style():
        figure = Figure(figsize=(2.6 * columns + 0.8, 2.8 * rows + 0.4), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for axis, one in zip(axes, maps, strict=False):
            mesh = _map(axis, vessel, one, highest, labels=False)
            *lines, source = _title(vessel, one.case)
            largest = f"largest {one.gain.max():.2f}"
            axis.set_title("\n".join([*lines, f"{source}, {largest}" if source else largest]), fontsize=7.5)
        for axis in axes[len(maps) :]:
            axis.remove()
        figure.colorbar(mesh, ax=list(axes[: len(maps)]), label="minimum gain (1)", shrink=0.6, aspect=40)
        figure.suptitle(f"{vessel.name}: minimum gain over the directions of two thrusters", fontsize=10.0)
        figure.savefig(path, dpi=_DPI)


def _map(axis: Any, vessel: Vessel, one: GainMap, highest: float, labels: bool) -> Any:
    degrees = np.degrees(one.angles)
    mesh = axis.pcolormesh(
        degrees, degrees, one.gain.T, cmap=_COLOURS, vmin=0.0, vmax=highest, shading="gouraud", rasterized=True
    )
    peak = float(one.gain.max())
    # On a sheet the lines are the same ones everywhere.
    steps = [step for step in (0.25, 0.1, 0.05, 0.02) if peak > 3.0 * step] if labels else [0.25]
    step = steps[0] if steps else 0.01
    levels = np.arange(step, peak, step)
    if len(levels):
        lines = axis.contour(degrees, degrees, one.gain.T, levels=levels, colors="white", linewidths=0.6, alpha=0.8)
        if labels:
            axis.clabel(lines, fontsize=7.0, fmt="%.2f")
    first, second = one.case.axes
    axis.set_xlabel(f"{_name(vessel, first)} (deg)")
    axis.set_ylabel(f"{_name(vessel, second)} (deg)")
    axis.set_xticks(range(-180, 181, 90))
    axis.set_yticks(range(-180, 181, 90))
    axis.grid(visible=False)
    axis.set_aspect("equal")
    return mesh


def _title(vessel: Vessel, case: MapCase) -> list[str]:
    """Return three lines."""
    thrusts = "equal thrusts" if case.equal_thrust else "own thrusts"
    first = [thrusts if case.method == "svd" else f"{thrusts}, unidirectional, {_METHODS[case.method]}"]
    second = []
    if case.lost is not None:
        second.append(f"{_name(vessel, case.lost)} lost")
    held = [j for j, can in enumerate(vessel.can_rotate) if can and j not in (*case.axes, case.lost)]
    if held and case.held is not None:
        second.append(f"{', '.join(_name(vessel, j) for j in held)} at {math.degrees(case.held):.0f}°")
    if not second:
        second.append("all thrusters")
    return [*first, ", ".join(second), f"[Ruth] Figure {case.source}" if case.source else ""]


def _name(vessel: Vessel, j: int) -> str:
    return f"{j + 1} {vessel.thruster_names[j].replace('_', ' ')}"


def _degrees(azimuth: FloatArray) -> str:
    return ", ".join(f"{value:.0f}" for value in np.degrees(azimuth)) + "°"


def _closed(outline: FloatArray) -> FloatArray:
    closed: FloatArray = np.vstack([outline, outline[:1]]).T
    return closed
