"""What a trial leaves in its folder: page, numbers, series, picture."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dp_tools.open_water.measures import MEASURES
from dp_tools.open_water.outcome import Outcome
from dp_tools.open_water.page import render
from dp_tools.open_water.plots import stacked
from dp_tools.open_water.record import QUANTITIES, UNITS
from dp_tools.run_folder import FolderError, make_writable

PAGE, NUMBERS, SERIES, PICTURE = "open_water.html", "open_water.json", "series.csv", "open_water.png"
_DPI = 110


@dataclass(frozen=True)
class TrialFolder:
    """Where the files go."""

    path: Path

    def prepare(self) -> None:
        """Make the folder. Raises FolderError if it cannot be written."""
        make_writable(self.path)

    def write(self, outcome: Outcome) -> None:
        """Write everything. Raises FolderError."""
        trial = outcome.trial
        span = (0.0, trial.duration) if trial.close_up is None else trial.windows[trial.close_up]
        try:
            text = json.dumps(_numbers(outcome), indent=1, allow_nan=False) + "\n"
            (self.path / NUMBERS).write_text(text, encoding="utf-8")
            (self.path / PAGE).write_text(render(outcome), encoding="utf-8")
            self._series(outcome)
            stacked(outcome, span, trial.title).savefig(self.path / PICTURE, dpi=_DPI)
        except OSError as error:
            raise FolderError(f"{self.path}: cannot be written: {error.strerror}") from error

    def _series(self, outcome: Outcome) -> None:
        trial, record = outcome.trial, outcome.record
        step = round(trial.series_step / trial.time_step)
        kept = slice(step - 1, None, step)
        heads, values = ["time_s", "advance_speed_m_per_s"], [record.t, record.advance_speed]
        if record.submergence_ratio is not None:
            heads.append("submergence_ratio")
            values.append(record.submergence_ratio)
        for name, case in record.cases.items():
            for quantity in QUANTITIES:
                unit = UNITS[quantity].replace(" ", "_")
                heads.append(f"{name}.{quantity}" + ("" if unit == "1" else f"_{unit}"))
                values.append(getattr(case, quantity))
        with (self.path / SERIES).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(heads)
            writer.writerows([f"{value:.8g}" for value in row] for row in np.column_stack([v[kept] for v in values]))


def _numbers(outcome: Outcome) -> dict[str, Any]:
    trial = outcome.trial
    content: dict[str, Any] = {
        "trial": trial.name,
        "source": trial.source,
        "windows": {name: list(span) for name, span in trial.windows.items()},
        "table": {
            "window": trial.table.window,
            "units": {kind: MEASURES[kind].unit for kind in trial.table.kinds},
            "cases": {name: dict(zip(trial.table.kinds, row, strict=True)) for name, row in outcome.table.items()},
        },
        "figures": [
            {
                "name": figure.spec.name,
                "kind": figure.spec.kind,
                "case": figure.spec.case,
                "over": figure.spec.over,
                "window": figure.spec.window,
                "unit": figure.unit,
                "value": figure.value,
                "thesis": figure.spec.thesis,
                "source": figure.spec.source,
            }
            for figure in outcome.figures
        ],
    }
    if trial.sweep is not None:
        content["sweep"] = {
            "kind": trial.sweep.kind,
            "window": list(trial.sweep.window),
            "thesis": trial.sweep.thesis,
            "ratios": {row.title: list(row.ratios) for row in outcome.sweep},
        }
    return content
