"""The work of `dp propeller`: numbers, tables, pictures, files, in this order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from dp_tools.propeller.files import PropellerFolder
from dp_tools.propeller.plots import pictures_of
from dp_tools.propeller.study import Study, check_loading, study
from dp_tools.propeller.subject import Subject
from dp_tools.propeller.tables import comparison_table, printed_table, remarks, summary_table
from dp_tools.run_folder import FolderError


def run_propeller(
    console: Console, subjects: Sequence[Subject], last_loading: float, output: Path | None, plots: bool
) -> None:
    """Print the tables of some propellers, and write files if there is a folder.

    Parameters
    ----------
    console
        Where to print.
    subjects
        The propellers.
    last_loading
        Largest tau of plots and comparisons.
    output
        Folder; None for none.
    plots
        Write pictures too.

    Raises
    ------
    InputError
        If ``last_loading`` is not above 0.
    FolderError
        If the folder cannot be written.
    """
    check_loading(last_loading)
    folder = None if output is None else PropellerFolder(output.absolute())
    if folder is not None:
        folder.prepare([subject.name for subject in subjects])
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
    studies: list[Study] = []
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("propellers", total=len(subjects))
        for subject in subjects:
            bar.update(task, description=subject.name)
            studies.append(study(subject, last_loading))
            bar.advance(task)
    console.print(summary_table(studies))
    for one in studies:
        if one.comparisons:
            console.print(comparison_table(one))
        beside = printed_table(one)
        if beside is not None:
            console.print(beside)
        for line in remarks(one):
            console.print(line, highlight=False, markup=False, soft_wrap=True)
    if folder is None:
        return
    for one in studies:
        pictures = pictures_of(one) if plots else {}
        try:
            for name, draw in pictures.items():
                draw(folder.path / one.subject.name / name)
        except OSError as error:
            raise FolderError(f"{folder.path}: cannot be written: {error.strerror}") from error
        folder.write(one, tuple(pictures))
    console.print(f"written {folder.path}", soft_wrap=True)
