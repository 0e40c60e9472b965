"""Figures of merit: a scenario file asks for them, a run is measured, the thesis's numbers stand beside ours.

A kind is one class with its fields and how it is worked out; ``registry`` lists them all.
"""

from dp_tools.figures.base import ComparedFigure, FigureSpec, Measurement, WindowFigure
from dp_tools.figures.outcome import Figure, compute_figures, write_figures
from dp_tools.figures.registry import AnyFigure

__all__ = [
    "AnyFigure",
    "ComparedFigure",
    "Figure",
    "FigureSpec",
    "Measurement",
    "WindowFigure",
    "compute_figures",
    "write_figures",
]
