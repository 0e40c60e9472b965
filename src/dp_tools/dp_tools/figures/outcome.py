"""Figures of merit of one run beside what the thesis prints."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from dp_tools.figures.base import FigureSpec
from dp_tools.run_data import RunData
from marine_model import Vessel

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


@dataclass(frozen=True)
class Figure:
    """One figure of merit of one run.

    Parameters
    ----------
    spec
        What was asked for.
    value, low, high
        See ``Measurement``.
    """

    spec: FigureSpec
    value: float | None
    low: float | None = None
    high: float | None = None

    @property
    def unit(self) -> str:
        """SI, degrees for angles, 1 for a ratio."""
        return self.spec.unit

    @property
    def difference(self) -> float | None:
        """Ours minus the thesis's; None if either is missing."""
        if self.value is None or self.spec.thesis is None:
            return None
        return self.value - self.spec.thesis

    @property
    def held(self) -> bool | None:
        """Whether the bounds that the scenario names hold; None if it names none."""
        low, high = self.spec.at_least, self.spec.at_most
        if low is None and high is None:
            return None
        if self.value is None:
            return False
        return (low is None or self.value >= low) and (high is None or self.value <= high)


def compute_figures(run: RunData, scenario: Scenario, vessel: Vessel) -> tuple[Figure, ...]:
    """Return the figures that ``scenario`` asks for, in its order.

    Raises
    ------
    InputError
        If a series or part of the run that a figure needs is missing.
    """
    figures = []
    for spec in scenario.figures:
        found = spec.measure(run, scenario, vessel)
        low, high = (None, None) if spec.transient else (found.low, found.high)
        figures.append(Figure(spec, found.value, low, high))
    return tuple(figures)


def write_figures(path: Path, scenario: Scenario, figures: tuple[Figure, ...]) -> None:
    """Write figures.json."""
    entries = [
        {
            "name": figure.spec.name,
            "value": figure.value,
            "unit": figure.unit,
            "thesis": figure.spec.thesis,
            "low": figure.low,
            "high": figure.high,
        }
        for figure in figures
    ]
    document = {"run": scenario.run, "figures": entries}
    path.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", encoding="utf-8")
