"""The work of `dp detection`: campaigns, table, files, in this order."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from dp_tools.detection_report.campaigns import METHODS, confusion, run_campaigns
from dp_tools.detection_report.page import render
from dp_tools.run_folder import FolderError, make_writable
from marine_model import Vessel

PAGE, NUMBERS = "detection.html", "detection.json"


def run_detection(console: Console, vessel: Vessel, duration: float, seed: int, output: Path | None) -> None:
    """Run the campaigns of a vessel, print the confusion table, write page and numbers.

    Parameters
    ----------
    console
        Where to print.
    vessel
        The vessel.
    duration, seed
        Of the campaigns; s.
    output
        Folder; None: detection/<vessel>.

    Raises
    ------
    InputError
        If the vessel lacks a section that is needed.
    FolderError
        If the folder cannot be written.
    """
    folder = (output or Path("detection") / vessel.name).absolute()
    make_writable(folder)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("detection", total=len(METHODS))
        results = run_campaigns(vessel, duration, seed, lambda done: bar.update(task, completed=done))
    table = Table(
        title=Text(
            f"{vessel.name}: detection in {0.5 * duration:g} s of ventilation and {duration:g} s of moderate sea"
        )
    )
    table.add_column("")
    for result in results:
        table.add_column(Text(result.title), justify="right")
    for rows in zip(*(confusion(result) for result in results), strict=True):
        table.add_row(rows[0][0], *(value for _, value in rows))
    console.print(table)
    numbers = {
        "vessel": vessel.name,
        "duration": duration,
        "seed": seed,
        "methods": {
            method: {"rows": dict(confusion(result)), "delays": result.ventilation.delays.tolist()}
            for method, result in zip(METHODS, results, strict=True)
        },
    }
    try:
        (folder / NUMBERS).write_text(json.dumps(numbers, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        (folder / PAGE).write_text(render(vessel, results, duration, seed), encoding="utf-8")
    except OSError as error:
        raise FolderError(f"{folder}: cannot be written: {error.strerror}") from error
    console.print(f"written {folder}", soft_wrap=True, highlight=False)
