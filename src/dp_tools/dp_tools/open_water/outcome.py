"""What came out of a trial: the table of its cases, figures beside the thesis, and the sweep over other thrusts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from dp_tools.open_water.measures import MEASURES, Kind
from dp_tools.open_water.outcome_specs import Figure
from dp_tools.open_water.record import Record
from dp_tools.open_water.run import Progress, run_trial
from dp_tools.open_water.trial import Trial
from marine_model.errors import InputError


@dataclass(frozen=True)
class FigureValue:
    """One figure of the trial file with its value, in ``unit``."""

    spec: Figure
    value: float
    unit: str

    @property
    def difference(self) -> float | None:
        """Ours less the thesis's; None where the thesis prints none."""
        return None if self.spec.thesis is None else self.value - self.spec.thesis


@dataclass(frozen=True)
class SweepRow:
    """Ratio of every case to the first one, with another thrust."""

    title: str
    ratios: tuple[float, ...]


@dataclass(frozen=True)
class Outcome:
    """A trial that has been run."""

    trial: Trial
    record: Record
    table: dict[str, tuple[float, ...]]  # by case, a value for each of trial.table.kinds
    figures: tuple[FigureValue, ...]
    sweep: tuple[SweepRow, ...]


def total_time(trial: Trial) -> float:
    """Return how much time (s) is simulated, the sweep included."""
    return trial.duration + sum(duration for duration in _sweep_durations(trial))


def work_out(trial: Trial, progress: Progress | None = None) -> Outcome:
    """Run a trial and its sweep and measure.

    Parameters
    ----------
    trial
        What is run.
    progress
        Called with the simulated time (s) now and then, up to ``total_time``.

    Raises
    ------
    InputError
        If a figure is not finite, such as a ratio to nothing.
    """
    record = run_trial(trial, progress)
    table = {
        case.name: tuple(_value(record, trial, kind, case.name, trial.table.window) for kind in trial.table.kinds)
        for case in trial.cases
    }
    figures = tuple(_figure(record, trial, spec) for spec in trial.figures)
    return Outcome(trial, record, table, figures, tuple(_sweep(trial, progress)))


def _value(record: Record, trial: Trial, kind: Kind, case: str, window: str) -> float:
    value = MEASURES[kind].of(record.cases[case].part(record.window(*trial.windows[window])))
    if not math.isfinite(value):
        raise InputError(
            f"{kind} of case '{case}' in window '{window}': expected a finite number, found {value}; does the "
            "propeller give the thrust that is asked for?"
        )
    return value


def _figure(record: Record, trial: Trial, spec: Figure) -> FigureValue:
    value, unit = _value(record, trial, spec.kind, spec.case, spec.window), MEASURES[spec.kind].unit
    if spec.over is not None:
        base = _value(record, trial, spec.kind, spec.over, spec.window)
        if base == 0.0:
            raise InputError(f"figures.{spec.name}: expected a case '{spec.over}' with more than 0, found {base}")
        value, unit = value / base, "1"
    return FigureValue(spec, value, unit)


def _sweep_durations(trial: Trial) -> list[float]:
    return [] if trial.sweep is None else [trial.sweep.window[1]] * len(trial.sweep.variants)


def _sweep(trial: Trial, progress: Progress | None) -> Iterator[SweepRow]:
    if trial.sweep is None:
        return
    measure = MEASURES[trial.sweep.kind]
    done = trial.duration
    for variant, duration in zip(trial.sweep.variants, _sweep_durations(trial), strict=True):
        start = done

        def tell(time: float, start: float = start) -> None:
            if progress is not None:
                progress(start + time)

        record = run_trial(trial.variant(variant.thrust, duration), tell)
        window = record.window(*trial.sweep.window)
        values = [measure.of(record.cases[case.name].part(window)) for case in trial.cases]
        if not values[0] or not all(math.isfinite(value) for value in values):
            raise InputError(f"sweep: expected finite figures and the first not 0, found {values} ({variant.title})")
        yield SweepRow(variant.title, tuple(value / values[0] for value in values))
        done += duration
