"""Windows laid over one another in colours of their groups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from matplotlib.figure import Figure as Canvas

from dp_tools.report import style

SINCE_START = "time since the start of the window (s)"


def lines_of(groups: Mapping[str, tuple[str, ...]]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Return every window of every group, and how its line is drawn: a colour a group, which the legend names once."""
    for number, (name, windows) in enumerate(groups.items()):
        color = style.GROUPS[number % len(style.GROUPS)]
        for k, window in enumerate(windows):
            yield window, {"color": color, "linewidth": 1.0, "label": None if k else name}


def name_groups(figure: Canvas, axes: list[Any], x_label: str) -> None:
    """Put the legend of the groups above, and the label of the common axis below."""
    axes[-1].set_xlabel(x_label)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
