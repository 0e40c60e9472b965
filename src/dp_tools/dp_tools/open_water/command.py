"""The work of `dp open-water run`: the trial, tables, files, in this order."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from dp_tools.open_water.files import TrialFolder
from dp_tools.open_water.measures import MEASURES
from dp_tools.open_water.outcome import Outcome, total_time, work_out
from dp_tools.open_water.texts import figure_row, rows, sentence
from dp_tools.open_water.trial import Trial


def run_open_water(console: Console, trial: Trial, output: Path | None) -> None:
    """Run a trial, print its tables, write its files.

    Parameters
    ----------
    console
        Where to print.
    trial
        What is run.
    output
        Folder; None: open_water/<trial>.

    Raises
    ------
    InputError
        If a figure is not finite.
    FolderError
        If the folder cannot be written.
    """
    folder = TrialFolder((output or Path("open_water") / trial.name).absolute())
    folder.prepare()
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed:.0f} of {task.total:.0f} s"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task(trial.name, total=total_time(trial))
        outcome = work_out(trial, lambda time: bar.update(task, completed=time))
    for table in tables(outcome):
        console.print(table)
    with console.status("writing page and series"):
        folder.write(outcome)
    console.print(f"written {folder.path}", soft_wrap=True, highlight=False)


def tables(outcome: Outcome) -> list[Table]:
    """Return the tables for the terminal."""
    trial = outcome.trial
    start, end = trial.windows[trial.table.window]
    cases = Table(title=Text(f"{trial.title}, {start:g} s to {end:g} s"))
    cases.add_column("")
    for case in trial.cases:
        cases.add_column(Text(case.title), justify="right")
    for title, values in rows(outcome):
        cases.add_row(title, *values)
    found = [cases]
    if outcome.figures:
        compared = any(figure.spec.thesis is not None for figure in outcome.figures)
        figures = Table(title="Beside the thesis" if compared else "Figures")
        figures.add_column("figure")
        for head in ("ours", "thesis", "difference"):
            figures.add_column(head, justify="right")
        for figure in outcome.figures:
            row = figure_row(figure)
            figures.add_row(Text(row.title), row.ours, row.thesis or "–", row.difference or "–")
        found.append(figures)
    if trial.sweep is not None:
        title = sentence(MEASURES[trial.sweep.kind].title)
        sweep = Table(title=Text(f"{title} over that of {trial.cases[0].title.lower()}"))
        sweep.add_column("thrust demand")
        for case in trial.cases:
            sweep.add_column(Text(case.title), justify="right")
        for variant in outcome.sweep:
            sweep.add_row(Text(variant.title), *(f"{ratio:.3f}" for ratio in variant.ratios))
        if trial.sweep.thesis is not None:
            sweep.add_row("thesis", *(f"{ratio:.3f}" for ratio in trial.sweep.thesis))
        found.append(sweep)
    return found
