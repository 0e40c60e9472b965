"""Numbers of a trial as text, for the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass

from dp_tools.open_water.measures import MEASURES
from dp_tools.open_water.outcome import FigureValue, Outcome
from dp_tools.quantities import number, with_unit


@dataclass(frozen=True)
class FigureRow:
    """A figure as text."""

    title: str
    ours: str
    thesis: str
    difference: str
    remark: str


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """Return ``value`` and its unit, with a prefix from a thousand W, N or N m on."""
    if unit in ("W", "N", "N m"):
        for factor, prefix in ((1e6, "M"), (1e3, "k")):
            if abs(value) >= factor:
                return f"{number(value / factor, digits)} {prefix}{unit}"
    return f"{value:.3f}" if unit == "1" else with_unit(value, unit, digits)


def rows(outcome: Outcome) -> list[tuple[str, list[str]]]:
    """Return the table of cases: title of every kind of figure, and what it is in each case."""
    found = []
    for i, kind in enumerate(outcome.trial.table.kinds):
        measure = MEASURES[kind]
        found.append((sentence(measure.title), [quantity(row[i], measure.unit) for row in outcome.table.values()]))
    return found


def figure_row(figure: FigureValue) -> FigureRow:
    """Return a figure beside the thesis."""
    spec, unit = figure.spec, figure.unit
    difference = ""
    if figure.difference is not None:
        # As many digits as the thesis has, so that a difference below its rounding shows as one.
        difference = ("+" if figure.difference > 0.0 else "") + quantity(figure.difference, unit, 2).replace("-", "−")
    return FigureRow(
        title=spec.title,
        ours=quantity(figure.value, unit),
        thesis="" if spec.thesis is None else quantity(spec.thesis, unit),
        difference=difference,
        remark=" ".join(part for part in (spec.reason.strip(), f"({spec.source})" if spec.source else "") if part),
    )


def sentence(text: str) -> str:
    """Return ``text`` with a capital at its start."""
    return text[:1].upper() + text[1:]
