"""Stacked panels over one time axis, with events and windows marked."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dp_tools.report import style
from dp_tools.report.thinning import thin
from dp_tools.run_data import Series
from dp_tools.scenario import Event, Scenario
from dp_tools.signals import runs_of
from marine_model.guards import FloatArray

WIDTH = 10.6  # inch
# Fixed margins (inch), so that the time axes of all pictures on a page stand beneath one another.
_LEFT, _RIGHT, _BOTTOM, _GAP, _GAP_LEGEND = 0.92, 0.2, 0.5, 0.14, 0.36
_TOP_LEGEND, _TOP_LABELS, _TOP_SLANTED = 0.3, 0.17, 0.42
# More labels than this stand at an angle, or they run into one another.
_LEVEL_LABELS = 5


class Panels:
    """One picture of stacked plots that share their time axis.

    Parameters
    ----------
    labels
        Label of every y-axis, with its unit.
    scenario
        Its events and windows are marked.
    span
        (first, last) time shown, s.
    height
        Height of one panel, inch.
    marked
        Names of the windows that are shaded.
    own_legends
        True for a legend above every panel, False for one above all.
    right
        Margin at the right, inch; a second axis there needs more than the usual one.
    """

    def __init__(
        self,
        labels: Sequence[str],
        scenario: Scenario,
        span: tuple[float, float],
        height: float = 1.5,
        marked: Sequence[str] = (),
        own_legends: bool = False,
        right: float = _RIGHT,
    ) -> None:
        self.span = span
        self._right = right
        shown = [e for e in scenario.events if e.label and span[0] <= e.at < span[1]]
        self._slanted = len(shown) > _LEVEL_LABELS
        count = len(labels)
        top = _TOP_LEGEND + (_TOP_SLANTED if self._slanted else _TOP_LABELS if shown else 0.0)
        gap = _GAP_LEGEND if own_legends else _GAP
        self._own_legends = own_legends
        total = top + count * height + (count - 1) * gap + _BOTTOM
        self.figure = Figure(figsize=(WIDTH, total))
        grid = {
            "left": _LEFT / WIDTH,
            "right": 1.0 - right / WIDTH,
            "bottom": _BOTTOM / total,
            "top": 1.0 - top / total,
            "hspace": gap / height,
        }
        axes = self.figure.subplots(count, 1, sharex=True, gridspec_kw=grid)
        self.axes: list[Any] = np.atleast_1d(axes).tolist()
        self._handles: list[dict[str, Any]] = [{} for _ in labels]
        for axis, label in zip(self.axes, labels, strict=True):
            axis.set_ylabel(label)
            # From the left edge inwards, so that labels of one and of two lines both fit.
            axis.yaxis.label.set_verticalalignment("top")
            axis.yaxis.set_label_coords(-(_LEFT - 0.04) / (WIDTH - _LEFT - right), 0.5)
            axis.set_xlim(*span)
            self._mark(axis, scenario, marked)
        self.axes[-1].set_xlabel("time (s)")
        for event in shown:
            self._label(event)

    def shade(self, panel: int, start: float, end: float) -> None:
        """Shade a stretch of one panel in which something is faulty."""
        if end > self.span[0] and start < self.span[1]:
            drawn = self.axes[panel].axvspan(start, end, color=style.FAULT, linewidth=0, zorder=0.5)
            self.add_to_legend(panel, "faulty", drawn)

    def band(self, panel: int, low: float, high: float, label: str, color: str) -> None:
        """Shade what lies between two values of one panel."""
        drawn = self.axes[panel].axhspan(low, high, color=color, linewidth=0, zorder=0.5)
        self.add_to_legend(panel, label, drawn)

    def draw(self, panel: int, t: FloatArray, values: FloatArray, label: str, color: str, **line: Any) -> None:
        """Draw one signal; a label that came before is not repeated in the legend."""
        inside = (t >= self.span[0] - 1e-6) & (t <= self.span[1] + 1e-6)
        (drawn,) = self.axes[panel].plot(*thin(t[inside], values[inside]), color=color, label=label, **line)
        self.add_to_legend(panel, label, drawn)

    def stretches(self, panel: int, t: FloatArray, flags: NDArray[np.bool_], label: str, color: str) -> None:
        """Draw when ``flags`` are up as bars at the foot of a panel."""
        # A run that goes on to the end of the signal ends with its last sample.
        spans = [(float(t[first]), float(t[min(after, len(t) - 1)])) for first, after in runs_of(flags)]
        bars = [(start, end - start) for start, end in spans if end >= self.span[0] and start <= self.span[1]]
        if bars:
            axis = self.axes[panel]
            drawn = axis.broken_barh(bars, (0.0, 0.07), color=color, transform=axis.get_xaxis_transform(), zorder=3)
            drawn.set_label(label)
            self.add_to_legend(panel, label, drawn)

    def add_to_legend(self, panel: int, label: str, drawn: Any) -> None:
        """Name what was drawn beside this class, e.g. on an axis at the right; a label that came before stays."""
        self._handles[panel].setdefault(label, drawn)

    def level(self, panel: int, value: float, label: str) -> None:
        """Draw a limit as a thin level line."""
        drawn = self.axes[panel].axhline(value, color=style.LIMIT, linewidth=0.8, linestyle=(0, (1, 2)))
        self.add_to_legend(panel, label, drawn)

    def at_least(self, panel: int, height: float) -> None:
        """Widen the y-axis of a panel to ``height``, so that noise about a constant does not fill it."""
        low, high = self.axes[panel].get_ylim()
        if high - low < height:
            middle = 0.5 * (low + high)
            self.axes[panel].set_ylim(middle - 0.5 * height, middle + 0.5 * height)

    def means(self, panel: int, series: Series, scenario: Scenario, marked: Sequence[str], unit: str) -> None:
        """Draw the mean of one signal over every marked window in view, and say how much it is."""
        for i, name in enumerate(marked):
            start, end = scenario.windows[name]
            # The last sample comes one step before the end.
            if start < self.span[0] or end > self.span[1] + 1.0:
                continue
            mean = float(series.window(start, end).values.mean())
            color = style.WINDOW_EDGES[i % len(style.WINDOW_EDGES)]
            self.axes[panel].hlines(mean, start, end, color=color, linewidth=2.2, zorder=4)
            self.axes[panel].annotate(
                f"{name}: mean {mean:.2f} {unit}",
                (0.5 * (start + end), 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, -4),
                textcoords="offset points",
                ha="center",
                va="top",
                color=color,
                fontweight="bold",
            )
        if marked:
            low, high = self.axes[panel].get_ylim()
            self.axes[panel].set_ylim(low, high + 0.16 * (high - low))

    def headline(self, text: str) -> None:
        """Put a title at the top, for a picture that stands alone."""
        self.figure.text(
            0.01,
            1.0 - 0.06 / self.figure.get_figheight(),
            text,
            va="top",
            fontsize=11.5,
            fontweight="bold",
            color=style.INK,
        )

    def legends(self) -> None:
        """Say which line is what, above the panels."""
        if self._own_legends:
            for i, (axis, own) in enumerate(zip(self.axes, self._handles, strict=True)):
                if len(own) < 2:
                    continue  # the label of the axis says it all
                if i == 0:
                    self._legend_on_top(own)
                    continue
                axis.legend(
                    handles=list(own.values()),
                    labels=list(own),
                    loc="lower right",
                    bbox_to_anchor=(1.0, 1.03),
                    ncols=len(own),
                )
            return
        merged: dict[str, Any] = {}
        for own in self._handles:
            merged |= own
        self._legend_on_top(merged)

    def _legend_on_top(self, handles: Mapping[str, Any]) -> None:
        self.figure.legend(
            handles=list(handles.values()),
            labels=list(handles),
            loc="upper right",
            bbox_to_anchor=(1.0 - self._right / WIDTH, 1.0 - 0.06 / self.figure.get_figheight()),
            ncols=len(handles),
        )

    def image(self) -> str:
        """Add legends and return the picture as a data URI (SVG)."""
        self.legends()
        return svg_uri(self.figure)

    def _mark(self, axis: Any, scenario: Scenario, marked: Sequence[str]) -> None:
        spans = [(scenario.windows[name], style.WINDOWS[i % len(style.WINDOWS)]) for i, name in enumerate(marked)]
        # The longest first, so that a window within another is seen.
        for (start, end), color in sorted(spans, key=lambda entry: entry[0][0] - entry[0][1]):
            axis.axvspan(start, end, color=color, linewidth=0, zorder=0)
        for event in scenario.events:
            if event.at > self.span[0] and event.at < self.span[1]:
                axis.axvline(event.at, color=style.MUTED, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)

    def _label(self, event: Event) -> None:
        self.axes[0].annotate(
            event.label,
            (event.at, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, 3),
            textcoords="offset points",
            fontsize=7.5,
            color=style.MUTED,
            rotation=24 if self._slanted else 0,
            rotation_mode="anchor",
            ha="left",
            va="bottom",
        )


def svg_uri(figure: Figure) -> str:
    """Return a figure as a data URI that holds its SVG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
