"""Pictures of a trial: stacked panels over time, and which submergence and Froude number were met."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.open_water.outcome import Outcome
from dp_tools.open_water.record import CaseRecord
from dp_tools.report import style
from dp_tools.report.panels import WIDTH, svg_uri
from dp_tools.report.scene import Picture
from dp_tools.report.thinning import thin
from marine_model.guards import FloatArray
from marine_model.ventilation.data import VentilationData
from marine_model.ventilation.static import modified_froude_number

Span = tuple[float, float]
_HEIGHT = 1.35  # inch, of a panel
# A thrust sensitivity beyond these comes from thrust demands near 0 and would flatten the rest.
_SENSITIVITY = (0.0, 2.0)


def pictures(outcome: Outcome) -> Iterator[Picture]:
    """Yield all pictures, in the order of the page."""
    trial = outcome.trial
    yield Picture(
        "The run", "Thrust demand dashed.", svg_uri(stacked(outcome, (0.0, trial.duration))), "All signals over time"
    )
    if trial.close_up is not None:
        span = trial.windows[trial.close_up]
        text = f"From {span[0]:g} s to {span[1]:g} s."
        yield Picture("Close up", text, svg_uri(stacked(outcome, span)), "All signals over a part of the time")
    ratio = outcome.record.submergence_ratio
    if trial.ventilation is not None and ratio is not None:
        yield Picture(
            "Which conditions were met",
            "As Figures 2.14 to 2.16: the modified Froude number (2.36) over the submergence ratio, and where the "
            "static model (2.40)-(2.43) has a thrust loss factor βTw of 0.8 and 0.2.",
            svg_uri(conditions(outcome, trial.ventilation, ratio)),
            "Path of modified Froude number and submergence ratio",
            narrow=True,
        )


def stacked(outcome: Outcome, span: Span, headline: str = "") -> Canvas:
    """Return panels over time, one a signal."""
    trial, record = outcome.trial, outcome.record
    chosen = record.window(*span)
    t = record.t[chosen]
    cases = {case.title: record.cases[case.name].part(chosen) for case in trial.cases}
    surroundings = []
    if trial.inflow.waves is not None or trial.inflow.current != 0.0:
        surroundings.append(("advance speed\n(m/s)", record.advance_speed[chosen]))
    if record.submergence_ratio is not None:
        surroundings.append(("submergence\nh/R", record.submergence_ratio[chosen]))
    signals = list(_signals(outcome, cases.values()))
    count = len(surroundings) + len(signals)
    height = 0.62 + _HEIGHT * count
    with style.plot_style():
        figure = Canvas(figsize=(WIDTH, height), layout="constrained")
        axes: list[Any] = np.atleast_1d(figure.subplots(count, 1, sharex=True)).tolist()
        for axis, (label, values) in zip(axes, surroundings, strict=False):
            axis.plot(*thin(t, values), color=style.INK, linewidth=0.9)
            axis.set_ylabel(label)
        for axis, (label, name, scale) in zip(axes[len(surroundings) :], signals, strict=True):
            for i, (title, case) in enumerate(cases.items()):
                color = style.THRUSTERS[i % len(style.THRUSTERS)]
                axis.plot(*thin(t, _values(case, name, scale)), color=color, linewidth=0.9, label=title)
            axis.set_ylabel(label)
            if name == "thrust":
                _demands(axis, t, cases.values(), scale)
        axes[-1].set_xlabel("time (s)")
        axes[-1].set_xlim(*span)
        figure.align_ylabels(axes)
        lines, labels = axes[len(surroundings)].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside upper right", ncols=min(len(labels), 6))
        if headline:
            axes[0].set_title(headline, loc="left", fontsize=11.0, fontweight="bold", color=style.INK)
    return figure


def _signals(outcome: Outcome, cases: Any) -> Iterator[tuple[str, str, float]]:
    """Yield label, signal and scale of every panel of the cases."""
    large = max(float(np.abs(case.thrust).max()) for case in cases) > 1e4
    factor, prefix = (1e-3, "k") if large else (1.0, "")
    yield f"thrust\n({prefix}N)", "thrust", factor
    if outcome.trial.ventilation is not None:
        yield "thrust loss\nfactor βT", "thrust_loss", 1.0
    else:
        yield "thrust\nsensitivity", "sensitivity", 1.0
    yield "shaft speed\n(Hz)", "shaft_speed", 1.0
    if any(np.ptp(case.pitch_ratio) > 0.0 for case in cases):
        yield "pitch ratio\nP/D", "pitch_ratio", 1.0
    yield f"motor torque\n({prefix}N m)", "torque", factor
    yield ("motor power\n(MW)", "power", 1e-6) if large else ("motor power\n(W)", "power", 1.0)


def _values(case: CaseRecord, name: str, scale: float) -> FloatArray:
    if name != "sensitivity":
        return np.asarray(scale * getattr(case, name))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = case.thrust / case.thrust_demanded
    return np.where((ratio >= _SENSITIVITY[0]) & (ratio <= _SENSITIVITY[1]), ratio, np.nan)


def _demands(axis: Any, t: FloatArray, cases: Any, scale: float) -> None:
    """Draw every demand once."""
    drawn: list[FloatArray] = []
    for case in cases:
        if any(np.array_equal(case.thrust_demanded, other) for other in drawn):
            continue
        drawn.append(case.thrust_demanded)
        label = "demand" if len(drawn) == 1 else None
        axis.plot(
            *thin(t, scale * case.thrust_demanded), color=style.INK, linewidth=0.9, linestyle=(0, (4, 3)), label=label
        )


def conditions(outcome: Outcome, ventilation: VentilationData, ratio: FloatArray) -> Canvas:
    """Return a picture of which F_nh2 every case met at which h/R (``ratio``)."""
    trial, record = outcome.trial, outcome.record
    diameter = trial.propeller.diameter
    with style.plot_style():
        figure = Canvas(figsize=(5.6, 4.0), layout="constrained")
        axis = figure.subplots()
        for i, case in enumerate(trial.cases):
            found = record.cases[case.name]
            froude = [
                modified_froude_number(n, diameter, p, x)
                for n, p, x in zip(found.shaft_speed.tolist(), found.pitch_ratio.tolist(), ratio.tolist(), strict=True)
            ]
            color = style.THRUSTERS[i % len(style.THRUSTERS)]
            axis.plot(*_path(ratio, np.array(froude)), color=color, linewidth=0.6, label=case.title)
        _boundaries(axis, ventilation, (float(ratio.min()), float(ratio.max())))
        axis.set_xlabel("submergence ratio h/R")
        axis.set_ylabel("modified Froude number")
        axis.set_ylim(0.0, None)
        figure.legend(loc="outside upper right", ncols=2)
    return figure


def _path(x: FloatArray, y: FloatArray, points: int = 4000) -> tuple[FloatArray, FloatArray]:
    step = max(1, len(x) // points)
    return x[::step], y[::step]


def _boundaries(axis: Any, ventilation: VentilationData, limits: Span) -> None:
    """Draw F_nh2 at beta_Tw = 0.8 and 0.2: the higher of both bands, (2.50)."""
    x = np.linspace(limits[0], limits[1], 101)
    for beta, dashes in ((0.8, (0, (5, 2))), (0.2, (0, (1, 1.5)))):
        bands = [ventilation.line(band, beta) for band in ("plus", "minus")]
        plus = np.array([bands[0](float(value)) for value in x])
        minus = np.array([bands[1](float(value)) for value in x])
        highest = np.maximum(plus, np.where(x < ventilation.minus_end, minus, -np.inf))
        axis.plot(x, highest, color=style.LIMIT, linewidth=1.1, linestyle=dashes, label=f"βTw = {beta:g}")
