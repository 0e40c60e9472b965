"""Pictures of `dp compare`: sets in space and in planes, the asteroid, portions, thrust over speed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from dp_tools.compare.azimuth_study import AzimuthStudy
from dp_tools.compare.group_study import GroupStudy
from dp_tools.compare.polytope import Polytope
from dp_tools.compare.portion_study import PLANES, SHARES, PortionStudy
from dp_tools.compare.speed_study import SpeedStudy
from dp_tools.compare.study import Comparison
from dp_tools.quantities import number
from dp_tools.report import style
from dp_tools.report.panels import WIDTH
from marine_model.guards import FloatArray
from thrust_allocator.methods.cross import AXES

_EXACT, _METHOD, _PSEUDO = style.COMMANDED, style.DESIRED, style.LIMIT
_SOLIDS = 4  # in one picture
_DRAWN = 6  # one of so many points of an outline that areas need more of


@dataclass(frozen=True, eq=False)
class Drawing:
    """A picture and what is written beside it.

    Attributes
    ----------
    name
        File name without ending.
    title, text, alt
        Above it, below it, in its place.
    figure
        The picture.
    narrow
        Not as wide as the page.
    """

    name: str
    title: str
    text: str
    alt: str
    figure: Figure
    narrow: bool = False


def drawings(comparison: Comparison) -> Iterator[Drawing]:
    """Yield all pictures; inside ``style.plot_style()``."""
    for i, study in enumerate(comparison.groups, start=1):
        if len(study.group.axes) >= 3:
            yield _solids(study, f"sets_{i}")
        if len(study.group.axes) >= 2:
            yield _sections(study, f"sections_{i}")
    if comparison.azimuth is not None:
        yield _asteroid(comparison.azimuth)
    if comparison.portions is not None:
        yield _portions(comparison.portions)
    for i, speed in enumerate(comparison.speeds, start=1):
        yield _over_speed(speed, f"speed_{i}")


def _solids(study: GroupStudy, name: str) -> Drawing:
    group = study.group
    triples = list(combinations(range(len(group.axes)), 3))[:_SOLIDS]
    columns = 1 if len(triples) == 1 else 2
    rows = -(-len(triples) // columns)
    figure = Figure(figsize=(5.2 * columns, 4.6 * rows))
    printed = group.printed_octahedron()
    for i, triple in enumerate(triples, start=1):
        axis = figure.add_subplot(rows, columns, i, projection="3d")
        exact = study.exact.section(triple)
        _solid(axis, exact, _EXACT, 0.13)
        _solid(axis, printed.section(triple), _METHOD, 0.45)
        reach = np.maximum(np.abs(exact.vertices).max(axis=0), group.printed[list(triple)])
        for which, j, most in zip("xyz", triple, reach.tolist(), strict=True):
            getattr(axis, f"set_{which}lim")(-most, most)
            getattr(axis, f"set_{which}label")(f"{group.axes[j]} ({group.units[j]})")
        axis.view_init(elev=22.0, azim=-58.0)
        axis.set_box_aspect((1.0, 1.0, 1.0), zoom=0.95)
        axis.tick_params(labelsize=7.0)
        axis.locator_params(nbins=5)
        others = [axis_name for k, axis_name in enumerate(group.axes) if k not in triple]
        if others:
            axis.set_title(f"no {', '.join(others)}", fontsize=9.0, y=0.97)
    figure.legend(
        handles=[_patch(_EXACT, 0.3, "attainable, exact"), _patch(_METHOD, 0.6, "octahedron, (3.1)")],
        loc="lower center",
        ncols=2,
    )
    figure.subplots_adjust(left=0.0, right=0.94, top=1.0, bottom=0.06, wspace=0.0, hspace=0.0)
    return Drawing(
        name,
        f"{group.name}: what is attainable and the octahedron",
        "All that the thrusters give along their fixed directions, blue, and what (3.1) lets pass with the largest "
        "forces as printed, red.",
        "Octahedron within the attainable set",
        figure,
        narrow=columns == 1,
    )


def _solid(axis: Any, body: Polytope, color: str, alpha: float) -> None:
    axis.add_collection3d(
        Poly3DCollection(body.faces(), facecolors=color, edgecolors=color, alpha=alpha, linewidths=0.9)
    )


def _patch(color: str, alpha: float, label: str) -> Any:
    return Patch(facecolor=color, alpha=alpha, label=label)


def _sections(study: GroupStudy, name: str) -> Drawing:
    group = study.group
    m = len(group.axes)
    pairs = list(combinations(range(m), 2))
    # With three axes once more beside a force along the third: two sets may differ there alone.
    half = 0.5 / study.exact.load(np.eye(m))
    panels = [(pair, np.zeros(m)) for pair in pairs] + [(pair, half) for pair in pairs if m == 3]
    columns = min(3, len(pairs))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(WIDTH, 3.4 * rows + 0.5), layout="constrained")
    sets = (
        (study.exact, _EXACT, "-", "attainable, exact"),
        (group.printed_octahedron(), _METHOD, "-", "octahedron, (3.1), as printed"),
        (group.by_pseudo_inverse(), _PSEUDO, (0, (4, 2)), "pseudo-inverse within limits"),
        (group.served_octahedron(), style.FLAGGED, (0, (1, 1.5)), "octahedron of what is served"),
    )
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, (pair, at) in zip(axes, panels, strict=False):
        for body, color, line, label in sets:
            corners = body.slice_corners(pair, at)
            if corners is not None:
                axis.fill(*corners.T, color=color, alpha=0.1, linewidth=0.0)
                axis.plot(*_closed(corners), color=color, linestyle=line, label=label)
        if at.any():
            (third,) = set(range(m)) - set(pair)
            axis.set_title(f"{number(float(at[third]))} {group.units[third]} of {group.axes[third]}", fontsize=9.0)
        axis.margins(0.06)
        axis.set_xlabel(f"{group.axes[pair[0]]} ({group.units[pair[0]]})")
        axis.set_ylabel(f"{group.axes[pair[1]]} ({group.units[pair[1]]})")
    for axis in axes[len(panels) :]:
        axis.remove()
    lines, labels = axes[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=4)
    text = {
        2: "",
        3: "Above: third axis zero. Below: at half of what is attainable of it alone. ",
    }.get(m, "Other axes zero. ")
    return Drawing(
        name,
        f"{group.name}: sections",
        f"{text}Where lines lie on one another, the sets are the same.",
        "Sections of the sets in planes of two axes",
        figure,
    )


def _asteroid(study: AzimuthStudy) -> Drawing:
    figure = Figure(figsize=(6.4, 6.6), layout="constrained")
    axis = figure.subplots()
    bearings = np.linspace(0.0, 2.0 * np.pi, 721)
    asteroid = study.limit * np.column_stack([np.cos(bearings) ** 3, np.sin(bearings) ** 3])
    angle = np.radians(study.present)
    kept = study.room * np.array(
        [[np.cos(angle), 0.0], [0.0, np.sin(angle)], [-np.cos(angle), 0.0], [0.0, -np.sin(angle)]]
    )
    # Sway to the right and surge upwards, as the vehicle is seen from above.
    for outline, color, line, label in (
        (study.apart_set.vertices[::_DRAWN], style.MEASURED, "-", "every propeller at its own angle"),
        (study.together_outline[::_DRAWN], _EXACT, "-", "at one common angle, any thrusts"),
        (asteroid, _METHOD, "-", "asteroid, (16)"),
        (kept, _PSEUDO, (0, (4, 2)), f"kept at {study.present:g}°, pseudo-inverse"),
    ):
        axis.fill(outline[:, 1], outline[:, 0], color=color, alpha=0.12, linewidth=0.0)
        closed = _closed(outline)
        axis.plot(closed[1], closed[0], color=color, linestyle=line, label=label)
    for case, marker in zip(study.cases, ("o", "s"), strict=True):
        reduced = case.reduced if case.asteroid < 1.0 else (case.surge, case.sway)
        axis.annotate(
            "", (reduced[1], reduced[0]), (case.sway, case.surge), arrowprops={"arrowstyle": "->", "color": style.INK}
        )
        axis.plot(
            case.sway,
            case.surge,
            marker,
            color=style.INK,
            markersize=5.0,
            linestyle="none",
            label=f"demand of {case.surge:g} N, {case.sway:g} N".replace("-", "−"),
        )
    axis.set_aspect("equal")
    axis.margins(0.05)
    axis.set_xlabel("sway (N)")
    axis.set_ylabel("surge (N)")
    figure.legend(loc="outside lower center", ncols=2)
    return Drawing(
        "asteroid",
        "Four azimuth propellers: asteroid and what is attainable",
        f"Surge and sway that can be had together with {study.moment:g} N m of yaw. The arrow is the reduction (18). "
        f"Dashed: what the pseudo-inverse gives if the propellers stay at {study.present:g}°.",
        "Asteroid within the attainable surge and sway",
        figure,
        narrow=True,
    )


def _portions(study: PortionStudy) -> Drawing:
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots(1, 2)
    for axis, plane, section in zip(axes, PLANES, study.sections, strict=True):
        places = [AXES.index(one) for one in plane]
        axis.fill(*section.vertices.T, color=_EXACT, alpha=0.1, linewidth=0.0)
        axis.plot(*_closed(section.vertices), color=_EXACT, label="attainable, exact")
        for row, share in zip(study.rows, SHARES, strict=True):
            x, y = (row.limits[place] for place in places)
            middle = row is study.middle
            axis.plot(
                [-x, x, x, -x, -x],
                [-y, -y, y, y, -y],
                color=_METHOD,
                linewidth=1.4 if middle else 0.8,
                alpha=1.0 if middle else 0.55,
                label=f"equal portions, P_x = {share:g}" if middle else None,
            )
            axis.annotate(
                f"{share:g}",
                (x, y),
                textcoords="offset points",
                xytext=(-2, -8),
                ha="right",
                fontsize=7.5,
                color=style.MUTED,
            )
        axis.margins(0.07)
        axis.set_xlabel(f"{plane[0]} (N)")
        axis.set_ylabel(f"{plane[1]} (N m)")
    lines, labels = axes[0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=2)
    return Drawing(
        "portions",
        "Portions and what is attainable",
        "Other axes zero, at rest. Numbers at the corners: P_x, the portion of surge.",
        "Rectangles of portions within the attainable set",
        figure,
    )


def _over_speed(study: SpeedStudy, name: str) -> Drawing:
    figure = Figure(figsize=(WIDTH, 4.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    looks: dict[bool, tuple[str, str]] = {True: (_EXACT, "with compensation, (8)"), False: (_METHOD, "without, (7)")}
    for compensated, (color, label) in looks.items():
        for truth, line, words in (("equilibrium", "-", "torques in equilibrium"), ("map", (0, (1, 1.5)), "Table 2")):
            way: Any = (truth, compensated)
            name_of = f"{label}, {words}"
            left.plot(study.speeds, study.over_speed[way], color=color, linestyle=line)
            right.plot(study.top_demands, study.at_top[way], color=color, linestyle=line, label=name_of)
    left.hlines(study.demands, *study.speeds[[0, -1]], color=style.MUTED, linewidth=0.8, linestyle=(0, (6, 3)))
    left.plot(study.speeds, study.thrust_max, color=_PSEUDO, label="T_max, Table 4")
    left.set_xlabel("speed through the water (m/s)")
    left.set_ylabel("achieved thrust (N)")
    right.plot(
        study.top_demands[[0, -1]], study.top_demands[[0, -1]], color=style.MUTED, linestyle=(0, (6, 3)), linewidth=0.8
    )
    right.axhline(study.thrust_max[-1], color=_PSEUDO)
    right.set_xlabel(f"demanded thrust at {study.speeds[-1]:g} m/s (N)")
    right.set_ylabel("achieved thrust (N)")
    (limit,), (words_of,) = left.get_legend_handles_labels()
    lines, labels = right.get_legend_handles_labels()
    figure.legend(
        [*lines, limit, left.collections[0]], [*labels, words_of, "demanded"], loc="outside lower center", ncols=3
    )
    return Drawing(
        name,
        f"Drive of {study.thruster.replace('_', ' ')}: achieved against demanded thrust",
        "Left: over the speed, demands of a quarter, a half and all of T_max at the largest speed. Right: over the "
        "demand, at the largest speed. Codes are whole numbers.",
        "Achieved thrust over speed and over demand, with and without compensation",
        figure,
    )


def _closed(outline: FloatArray) -> FloatArray:
    closed: FloatArray = np.vstack([outline, outline[:1]]).T
    return closed
