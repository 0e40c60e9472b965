"""Stacked panels over one time axis, with events and windows marked."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from dp_tools.report import style
from dp_tools.report.thinning import thin
from dp_tools.scenario import Scenario
from marine_model.guards import FloatArray

WIDTH = 10.6  # inch
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
    """

    def __init__(
        self,
        labels: Sequence[str],
        scenario: Scenario,
        span: tuple[float, float],
        height: float = 1.5,
        marked: Sequence[str] = (),
    ) -> None:
        self.span = span
        self.figure = Figure(figsize=(WIDTH, height * len(labels) + 0.75), layout="constrained")
        self.axes: list[Any] = list(
            np.atleast_1d(self.figure.subplots(len(labels), 1, sharex=True)).tolist()
        )
        self._handles: dict[str, Any] = {}
        for axis, label in zip(self.axes, labels, strict=True):
            axis.set_ylabel(label)
            axis.set_xlim(*span)
            self._mark(axis, scenario, marked)
        self.figure.align_ylabels(self.axes)
        self.axes[-1].set_xlabel("time (s)")
        self._label_events(scenario)

    def draw(
        self, panel: int, t: FloatArray, values: FloatArray, label: str, color: str, **line: Any
    ) -> None:
        """Draw one signal; a label that came before is not repeated in the legend."""
        inside = (t >= self.span[0] - 1e-6) & (t <= self.span[1] + 1e-6)
        (drawn,) = self.axes[panel].plot(
            *thin(t[inside], values[inside]), color=color, label=label, **line
        )
        self._handles.setdefault(label, drawn)

    def level(self, panel: int, value: float, label: str) -> None:
        """Draw a limit as a thin level line."""
        drawn = self.axes[panel].axhline(value, color=style.LIMIT, linewidth=0.8, linestyle=(0, (1, 2)))
        self._handles.setdefault(label, drawn)

    def at_least(self, panel: int, height: float) -> None:
        """Widen the y-axis of a panel to ``height``, so that noise about a constant does not fill it."""
        low, high = self.axes[panel].get_ylim()
        if high - low < height:
            middle = 0.5 * (low + high)
            self.axes[panel].set_ylim(middle - 0.5 * height, middle + 0.5 * height)

    def legend(self) -> None:
        """Put one legend for all panels above them."""
        self.figure.legend(
            handles=list(self._handles.values()),
            labels=list(self._handles),
            loc="outside upper right",
            ncols=len(self._handles),
        )

    def image(self) -> str:
        """Return the picture as a data URI (SVG)."""
        self.legend()
        return svg_uri(self.figure)

    def _mark(self, axis: Any, scenario: Scenario, marked: Sequence[str]) -> None:
        for i, name in enumerate(marked):
            start, end = scenario.windows[name]
            axis.axvspan(start, end, color=style.WINDOWS[i % len(style.WINDOWS)], linewidth=0, zorder=0)
        for event in scenario.events:
            if event.at > self.span[0] and event.at < self.span[1]:
                axis.axvline(event.at, color=style.MUTED, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)

    def _label_events(self, scenario: Scenario) -> None:
        shown = [e for e in scenario.events if e.label and self.span[0] <= e.at < self.span[1]]
        slanted = len(shown) > _LEVEL_LABELS
        for event in shown:
            self.axes[0].annotate(
                event.label,
                (event.at, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2, 3),
                textcoords="offset points",
                fontsize=7.5,
                color=style.MUTED,
                rotation=28 if slanted else 0,
                ha="left",
                va="bottom",
            )


def svg_uri(figure: Figure) -> str:
    """Return a figure as a data URI that holds its SVG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
