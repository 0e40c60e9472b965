"""Looks of the plots: colours, line widths, fonts; readable when printed and by colour-blind readers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib as mpl

INK = "#20262e"
MUTED = "#6b7480"
GRID = "#e4e8ec"
DESIRED = "#d1495b"
COMMANDED = "#12466b"
MEASURED = "#6fb1d8"
RAW = "#c3cad2"
LIMIT = "#b08a2e"
FLAGGED = "#8e4585"
FAULT = "#f8d3d0"
BAND = "#d5ecd9"
# Okabe and Ito's colours, told apart by colour-blind readers too.
THRUSTERS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00")
WINDOWS = ("#eaf1f7", "#fcf2de", "#eaf5ec", "#f6ecf4")
# Windows laid over one another, e.g. without and with; dark enough for thin lines.
GROUPS = (DESIRED, COMMANDED, "#3f8f55", "#b8790f")
WINDOW_EDGES = ("#2b3a4d", "#b8790f", "#3f8f55", "#a05a92")

_SETTINGS = {
    "font.size": 9.0,
    "font.family": "DejaVu Sans",
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.7,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.xmargin": 0.0,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "lines.linewidth": 1.1,
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "legend.handlelength": 1.8,
    "legend.borderaxespad": 0.0,
    "path.simplify": True,
    "svg.fonttype": "path",
    # The same run gives the same file.
    "svg.hashsalt": "dp_tools",
}


@contextmanager
def plot_style() -> Iterator[None]:
    """Use the style inside the block."""
    with mpl.rc_context(_SETTINGS):
        yield
