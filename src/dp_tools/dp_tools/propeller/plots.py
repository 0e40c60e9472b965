"""Pictures of `dp propeller`, in the manner of [Ruth] Figures 2.2, 2.10 and 3.3-3.14."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from dp_tools.propeller.study import Columns, Study
from dp_tools.report import style

_DPI = 130
_COLOURS = "viridis"
_TAU, _TAU_D = "τ (1)", "desired τ (1)"
_CONTROLLERS = {
    "shaft speed": (style.THRUSTERS[0], "-"),
    "torque": (style.THRUSTERS[1], "-"),
    "power": (style.THRUSTERS[2], "-"),
    "torque/shaft speed": (style.THRUSTERS[5], (0, (4, 1.5))),
}
_PATHS = {
    "torque/pitch": ("torque/pitch, misjudged as in 3.6", style.THRUSTERS[2], "-"),
    "torque/shaft speed, least error": ("torque/shaft speed, least error", style.THRUSTERS[0], "-"),
    "fixed, largest pitch": ("P/D = {largest:.2f}", style.THRUSTERS[5], "-"),
    "fixed, best pitch at rest": ("P/D = {rest:.2f}", style.THRUSTERS[3], "-"),
}


def pictures_of(study: Study) -> Mapping[str, Callable[[Path], None]]:
    """Return the pictures that ``study`` has the numbers for: how to draw each, by file name."""
    kinds: tuple[tuple[str, bool, Callable[[Study, Path], None]], ...] = (
        ("open_water.png", "open_water" in study.tables, draw_open_water),
        ("efficiency.png", "efficiency" in study.tables, draw_efficiency),
        ("maps.png", "optimal" in study.tables, draw_maps),
        ("torque_shaft_speed.png", bool(study.torque_coefficients), draw_torque_shaft_speed),
        ("controllers.png", bool(study.comparisons), draw_controllers),
        ("sensitivity.png", bool(study.sensitivities), draw_sensitivities),
        ("ventilation.png", "ventilation" in study.tables, draw_ventilation),
    )
    return {name: partial(draw, study) for name, there, draw in kinds if there}


def draw_open_water(study: Study, path: Path) -> None:
    """Draw K_T, 10 K_Q and eta_0 over J, a line for every pitch ratio."""
    table = study.tables["open_water"]
    pitches = np.unique(table["pitch_ratio"])
    with style.plot_style():
        figure = Figure(figsize=(10.2, 3.5), layout="constrained")
        panels = (("K_T", "$K_T$", 1.0), ("K_Q", "10 $K_Q$", 10.0), ("efficiency", "$η_0$", 1.0))
        for axis, (column, label, factor) in zip(figure.subplots(1, 3), panels, strict=True):
            for pitch, color in zip(pitches, _shades(len(pitches)), strict=True):
                one = table["pitch_ratio"] == pitch
                axis.plot(table["J"][one], factor * table[column][one], color=color, label=f"{pitch:.3g}")
            axis.set_xlabel("advance number $J$ (1)")
            axis.set_ylabel(f"{label} (1)")
            axis.set_ylim(bottom=0.0)
        lines, labels = axis.get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside right center", title="P/D", title_fontsize=8.5)
        _title(figure, study, "open water")
        figure.savefig(path, dpi=_DPI)


def draw_efficiency(study: Study, path: Path) -> None:
    """Draw the efficiency over tau and pitch ratio with the paths of the controllers, Figures 2.2 and 3.5."""
    tau, pitch, eta = _grid(study.tables["efficiency"], "tau", "pitch_ratio", "efficiency")
    best = study.summary.best
    with style.plot_style():
        figure = Figure(figsize=(7.6, 4.6), layout="constrained")
        axis = figure.subplots()
        mesh = axis.pcolormesh(tau, pitch, eta.T, cmap=_COLOURS, vmin=0.0, shading="gouraud", rasterized=True)
        lines = axis.contour(tau, pitch, eta.T, levels=np.arange(0.1, 1.0, 0.1), colors="white", linewidths=0.6)
        axis.clabel(lines, fontsize=7.0, fmt="%.1f")
        paths = (
            ("optimal", "optimal, $k$(τ)", "-", 2.2),
            ("torque/pitch", "torque/pitch, misjudged as in 3.6", (0, (4, 1.5)), 1.4),
            ("torque/shaft speed, least error", "torque/shaft speed, least error", (0, (1, 1)), 1.8),
        )
        for name, label, dashes, width in paths:
            one = study.paths[name]
            axis.plot(one.loading, one.pitch_ratio, color=style.DESIRED, linestyle=dashes, linewidth=width, label=label)
        if best is not None and best.loading <= study.last_loading:
            axis.plot(
                best.loading, best.pitch_ratio, "o", color="white", markeredgecolor=style.INK, clip_on=False, zorder=5,
                label=f"largest, {best.efficiency:.3f} at τ = {best.loading:.2f}",
            )  # fmt: skip
        axis.set_xlabel(_TAU)
        axis.set_ylabel("pitch ratio $P/D$ (1)")
        axis.grid(visible=False)
        figure.colorbar(mesh, ax=axis, label="efficiency $η_0$ (1)")
        figure.legend(loc="outside lower center", ncols=2)
        _title(figure, study, "efficiency")
        figure.savefig(path, dpi=_DPI)


def draw_maps(study: Study, path: Path) -> None:
    """Draw g, h, m and the best K_Q, Figures 3.3, 3.4, 3.6 and 3.7."""
    table = study.tables["optimal"]
    panels = (
        ("h", r"$h$(τ) = $K_Q$/$K_T$ (1)"),
        ("m", r"$m$(τ) = 1/$\sqrt{K_T}$ (1)"),
        ("K_Q", "optimal $K_Q$ (1)"),
    )
    with style.plot_style():
        figure = Figure(figsize=(8.4, 5.6), layout="constrained")
        first, *others = figure.subplots(2, 2).ravel()
        mapping = study.tables.get("pitch_for_thrust")
        if mapping is None:
            first.text(0.5, 0.5, "not defined", ha="center", transform=first.transAxes, color=style.MUTED)
        else:
            first.plot(mapping["K_Td"], mapping["pitch_ratio"], color=style.COMMANDED)
        first.set_xlabel("$K_{Td}$ (1)")
        first.set_ylabel("$P/D$ = $g$($K_{Td}$) (1)")
        for axis, (column, label) in zip(others, panels, strict=True):
            axis.plot(table["tau"], table[column], color=style.COMMANDED)
            axis.set_xlabel(_TAU)
            axis.set_ylabel(label)
        _title(figure, study, "maps of the controllers")
        figure.savefig(path, dpi=_DPI)


def draw_torque_shaft_speed(study: Study, path: Path) -> None:
    """Draw torque/shaft-speed control beside the optimum, Figures 3.8 and 3.9."""
    with style.plot_style():
        figure = Figure(figsize=(9.6, 3.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        best = study.paths["optimal"]
        left.plot(best.loading, best.efficiency, color=style.RAW, linewidth=3.0, label="optimal")
        for (name, K_Qc), color in zip(study.torque_coefficients.items(), style.THRUSTERS, strict=False):
            one = study.paths[f"torque/shaft speed, {name}"]
            label = f"$K_{{Qc}}$ = {K_Qc:.4f}, {name}"
            if name == "least error":
                left.plot(one.loading, one.efficiency, color=color)
            right.plot(one.loading, 100.0 * one.relative_error, color=color, label=label)
        for axis, label in ((left, "efficiency $η_0$ (1)"), (right, "relative loss of efficiency (%)")):
            axis.set_xlabel(_TAU)
            axis.set_ylabel(label)
            axis.set_ylim(bottom=0.0)
        figure.legend(loc="outside lower center", ncols=2)
        _title(figure, study, "torque/shaft-speed control")
        figure.savefig(path, dpi=_DPI)


def draw_controllers(study: Study, path: Path) -> None:
    """Draw the relative loss of efficiency of four controllers, Figure 3.14."""
    limits, rest = study.subject.pitch_range, study.summary.bollard_pitch_ratio
    values = {"largest": limits[1] if limits else 0.0, "rest": rest or 0.0}
    with style.plot_style():
        figure = Figure(figsize=(9.6, 3.9), layout="constrained")
        for axis, top in zip(figure.subplots(1, 2), (None, 5.0), strict=True):
            for name, (label, color, dashes) in _PATHS.items():
                one = study.paths[name]
                axis.plot(
                    one.loading, 100.0 * one.relative_error, color=color, linestyle=dashes, label=label.format(**values)
                )
            axis.set_xlabel(_TAU)
            axis.set_ylabel("relative loss of efficiency (%)")
            axis.set_ylim(0.0, top)
        figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        _title(figure, study, "controllers beside the optimum; right, the lowest 5 %")
        figure.savefig(path, dpi=_DPI)


def draw_sensitivities(study: Study, path: Path) -> None:
    """Draw st, sn, sq and sp over tau_d, Figures 3.10-3.13."""
    panels = (
        ("thrust", "thrust, $T/T_d$ (1)"),
        ("shaft_speed", "shaft speed, $n/n_d$ (1)"),
        ("torque", "torque, $Q_p/Q_d$ (1)"),
        ("power", "power, $P/P_d$ (1)"),
    )
    with style.plot_style():
        figure = Figure(figsize=(8.8, 6.4), layout="constrained")
        for axis, (column, label) in zip(figure.subplots(2, 2).ravel(), panels, strict=True):
            if "pitch, least" in study.sensitivities and column != "shaft_speed":
                _area(axis, study, column)
            for name, (color, dashes) in _CONTROLLERS.items():
                one = study.sensitivities.get(name)
                if one is not None:
                    axis.plot(
                        one.desired_loading, getattr(one, column), color=color, linestyle=dashes, label=name, alpha=0.9
                    )
            axis.set_xlabel(_TAU_D)
            axis.set_ylabel(label)
            axis.set_xlim(left=0.0)
        # The first panel has them all.
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
        _title(figure, study, f"sensitivity, fixed pitch at P/D = {study.summary.pitch_ratio:.3g}")
        figure.savefig(path, dpi=_DPI)


def _area(axis: Any, study: Study, column: str) -> None:
    """Fill what pitch control covers: between the least and the largest pitch ratio, up to the end of thrust."""
    low, end, high = (study.sensitivities[f"pitch, {name}"] for name in ("least", "end of thrust", "largest"))
    tau = np.concatenate([low.desired_loading, end.desired_loading, high.desired_loading[::-1]])
    values = np.concatenate([getattr(low, column), getattr(end, column), getattr(high, column)[::-1]])
    axis.fill(tau, values, color=style.RAW, alpha=0.6, linewidth=0.0, label="pitch, any shaft speed")


def draw_ventilation(study: Study, path: Path) -> None:
    """Draw beta_T and beta_Q over F_nh2 and h/R, Figure 2.10."""
    table = study.tables["ventilation"]
    with style.plot_style():
        figure = Figure(figsize=(9.6, 3.9), layout="constrained")
        axes = figure.subplots(1, 2)
        for axis, column, label in zip(axes, ("beta_T", "beta_Q"), ("thrust $β_T$", "torque $β_Q$"), strict=True):
            froude, depth, beta = _grid(table, "F_nh2", "h_over_R", column)
            mesh = axis.pcolormesh(
                froude, depth, beta.T, cmap=_COLOURS, vmin=0.0, vmax=1.0, shading="gouraud", rasterized=True
            )
            lines = axis.contour(froude, depth, beta.T, levels=np.arange(0.1, 1.0, 0.1), colors="white", linewidths=0.6)
            axis.clabel(lines, fontsize=7.0, fmt="%.1f")
            axis.set_title(f"{label}: what air leaves of it", fontsize=9.0)
            axis.set_xlabel("$F_{nh2}$ (1)")
            axis.set_ylabel("$h/R$ (1)")
            axis.grid(visible=False)
        figure.colorbar(mesh, ax=axes, label="loss factor (1)")
        _title(figure, study, "ventilation")
        figure.savefig(path, dpi=_DPI)


def _grid(table: Columns, first: str, second: str, value: str) -> tuple[Any, Any, Any]:
    """Return the axes of a flat map and its values, shape (first, second)."""
    x, y = np.unique(table[first]), np.unique(table[second])
    return x, y, table[value].reshape(len(x), len(y))


def _shades(count: int) -> list[Any]:
    # Not up to the brightest: it would not show on white.
    return [mpl.colormaps[_COLOURS](0.9 * i / max(count - 1, 1)) for i in range(count)]


def _title(figure: Any, study: Study, what: str) -> None:
    figure.suptitle(f"{study.subject.title}: {what}", fontsize=10.0)
