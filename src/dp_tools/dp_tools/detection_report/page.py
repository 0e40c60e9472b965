"""The page of `dp detection`: confusion table and delays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.detection_report.campaigns import MethodResult, confusion
from dp_tools.report import style
from dp_tools.report.panels import svg_uri
from dp_tools.report.template import fill_in
from marine_model import Vessel

_BIN = 0.02  # s, width of a bar


def render(vessel: Vessel, results: Sequence[MethodResult], duration: float, seed: int) -> str:
    """Return the page as HTML text; it refers to nothing outside itself."""
    tables = [confusion(result) for result in results]
    return fill_in(
        "detection.html",
        vessel=vessel,
        titles=[result.title for result in results],
        rows=[(names[0][0], [value for _, value in names]) for names in zip(*tables, strict=True)],
        facts=[
            ("Vessel", vessel.name),
            ("Ventilation", f"{0.5 * duration:g} s"),
            ("Moderate sea", f"{duration:g} s"),
            ("Seed", f"{seed}"),
            ("Sample", f"{vessel.measurement.sample_time:g} s"),
        ],
        delays=svg_uri(delays(vessel, results)),
        events=svg_uri(events(results)),
    )


def delays(vessel: Vessel, results: Sequence[MethodResult]) -> Canvas:
    """Return histograms of the time from the start of an event to its flag."""
    allowed = 2.0 * vessel.measurement.sample_time
    longest = max([allowed, *(float(r.ventilation.delays.max(initial=0.0)) for r in results)])
    edges = np.arange(0.0, longest + 2.0 * _BIN, _BIN) - 0.5 * _BIN
    with style.plot_style():
        figure = Canvas(figsize=(10.6, 1.9 * len(results) + 0.5), layout="constrained")
        axes = np.atleast_1d(figure.subplots(len(results), 1, sharex=True))
        for axis, result in zip(axes, results, strict=True):
            axis.hist(result.ventilation.delays, bins=edges.tolist(), color=style.COMMANDED)
            axis.axvline(allowed, color=style.LIMIT, linewidth=1.0, linestyle=(0, (4, 3)))
            axis.set_ylabel("events")
            axis.set_title(result.title, loc="left", fontsize=9.0)
        axes[-1].set_xlabel("delay (s); dashed: two samples")
    return figure


def events(results: Sequence[MethodResult]) -> Canvas:
    """Return a picture of every event over its depth and shaft speed."""
    with style.plot_style():
        figure = Canvas(figsize=(10.6, 3.4), layout="constrained")
        axes = np.atleast_1d(figure.subplots(1, len(results), sharey=True))
        for axis, result in zip(axes, results, strict=True):
            table = result.ventilation
            for chosen, color, label, marker in (
                (table.in_time, style.MEASURED, "found within two samples", "o"),
                (~table.in_time, style.DESIRED, "later or missed", "x"),
            ):
                speeds, depths = table.speeds[chosen], table.depths[chosen]
                axis.scatter(speeds, depths, s=13.0, color=color, marker=marker, linewidths=1.0, label=label)
            axis.set_title(result.title, loc="left", fontsize=9.0)
            axis.set_xlabel("mean shaft speed (Hz)")
            axis.set_xscale("log")
        axes[0].set_ylabel("least torque loss factor βQ")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower right", ncols=2)
    return figure
