"""Preallocated log of one run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dp_tools.run_data import SOMETIMES, WIDTHS, Labels, RunData, RunInfo, Series, width
from marine_model import Vessel
from marine_model.guards import FloatArray


class RunLog:
    """Arrays for every series of a run of known length; a row is written by index.

    Parameters
    ----------
    vessel
        That is sailed.
    samples, feedbacks
        Number of rows at the control rate and at the drivers' rate.
    at_feedback
        Names of the series at the drivers' rate; all others are at the control rate.
    """

    def __init__(self, vessel: Vessel, samples: int, feedbacks: int, at_feedback: frozenset[str]) -> None:
        n, m = len(vessel.thrusters), len(vessel.degrees_of_freedom)
        self._thrusters, self._axes = vessel.thruster_names, vessel.degrees_of_freedom
        self._at_feedback = at_feedback
        self.rows: Mapping[str, FloatArray] = {
            name: np.full((feedbacks if name in at_feedback else samples, width(name, n, m)), np.nan) for name in WIDTHS
        }
        self._changes: dict[str, tuple[list[float], list[str]]] = {}

    def note(self, name: str, t: float, word: str) -> None:
        """Note a word that changes over time, e.g. a mode, at ``t`` (s)."""
        times, words = self._changes.setdefault(name, ([], []))
        if not words or words[-1] != word:
            times.append(t)
            words.append(word)

    def finish(self, info: RunInfo, sample_times: FloatArray, feedback_times: FloatArray) -> RunData:
        """Return what was logged for the given times, one a row; of a series that comes and goes, what was written."""
        series = {}
        for name, rows in self.rows.items():
            t = feedback_times if name in self._at_feedback else sample_times
            rows = rows[: len(t)]
            if name in SOMETIMES:
                written = np.isfinite(rows).all(axis=1)
                if not written.any():
                    continue
                t, rows = t[written], rows[written]
            series[name] = Series(t, rows)
        labels = {name: Labels(np.array(times), tuple(words)) for name, (times, words) in self._changes.items()}
        return RunData(info, self._thrusters, series, labels, self._axes)
