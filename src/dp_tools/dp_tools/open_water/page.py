"""The page of a trial: one self-contained HTML file."""

from __future__ import annotations

from dp_tools.open_water.measures import MEASURES
from dp_tools.open_water.outcome import Outcome
from dp_tools.open_water.plots import pictures
from dp_tools.open_water.texts import figure_row, rows, sentence
from dp_tools.open_water.trial import Trial
from dp_tools.report.template import fill_in


def render(outcome: Outcome) -> str:
    """Return the page as HTML text; it refers to nothing outside itself."""
    trial = outcome.trial
    return fill_in(
        "open_water.html",
        outcome=outcome,
        subject=trial,
        trial=trial,
        facts=_facts(trial),
        rows=rows(outcome),
        figures=[figure_row(figure) for figure in outcome.figures],
        sweep_title="" if trial.sweep is None else sentence(MEASURES[trial.sweep.kind].title),
        pictures=list(pictures(outcome)),
    )


def _facts(trial: Trial) -> list[tuple[str, str]]:
    propeller = trial.propeller
    facts = [
        ("Propeller", propeller.model.replace("_", " ")),
        ("Diameter", f"{propeller.diameter:g} m"),
        ("Pitch ratio", f"{propeller.pitch_ratio:g}"),
        ("Duration", f"{trial.duration:g} s"),
        ("Time step", f"{1000.0 * trial.time_step:g} ms"),
    ]
    K_T, K_Q = propeller.build().coefficients(0.0)
    facts += [("K_T at J = 0", f"{float(K_T):.4f}"), ("K_Q at J = 0", f"{float(K_Q):.4f}")]
    return facts
