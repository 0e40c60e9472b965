"""The work of `dp compare`: numbers, tables, pictures, files, in this order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from dp_tools.compare.files import CompareFolder
from dp_tools.compare.group import Group
from dp_tools.compare.page import parts, render
from dp_tools.compare.plots import drawings
from dp_tools.compare.study import Comparison, compare_vessel, groups_to_compare
from dp_tools.report.style import plot_style
from marine_model import Vessel


def run_compare(console: Console, vessel: Vessel, demands: int, seed: int, output: Path | None) -> None:
    """Print what the methods give away, and write page, numbers and pictures.

    Parameters
    ----------
    console
        Where to print.
    vessel
        The vessel.
    demands, seed
        How many random demands for each part, and their seed.
    output
        Folder; None: compare/<vessel>.

    Raises
    ------
    InputError
        If a number is out of range, or a thruster pushes one way only.
    FolderError
        If the folder cannot be written.
    """
    folder = CompareFolder((output or Path("compare") / vessel.name).absolute())
    groups = groups_to_compare(vessel, demands, seed)
    folder.prepare()
    comparison = _work_out(console, vessel, groups, demands, seed)
    console.print(f"{vessel.name}: {vessel.description}", highlight=False, markup=False)
    for part in parts(comparison):
        console.print(f"\n[bold]{part.title}[/]", highlight=False)
        for sheet in part.sheets:
            console.print(sheet.table())
            if sheet.note:
                console.print(sheet.note, highlight=False, markup=False)
    with plot_style():
        drawn = list(drawings(comparison))
        folder.write(comparison, render(comparison, drawn), drawn)
    console.print(f"written {folder.path}", soft_wrap=True)


def _work_out(console: Console, vessel: Vessel, groups: Sequence[Group], demands: int, seed: int) -> Comparison:
    """Return the comparison, showing progress."""
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("random demands", total=demands * len(groups))
        return compare_vessel(vessel, groups, demands, seed, lambda done: bar.advance(task, done))
