"""Pictures that a scenario asks for beside those of every report: what they show, without any plotting library.

A kind is one class; ``registry`` lists them all, and ``dp_tools.report.asked`` says what draws each.
"""

from dp_tools.plot_specs.base import PlotSpec
from dp_tools.plot_specs.registry import AnyPlot

__all__ = ["AnyPlot", "PlotSpec"]
