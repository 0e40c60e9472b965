"""`dp open-water`: one thruster by itself in a basin."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from dp_tools.commands.root import console

open_water_app = typer.Typer()

TrialName = Annotated[str, typer.Argument(metavar="NAME|FILE", help="Trial.")]


@open_water_app.command("list")
def list_trials() -> None:
    """List the trials that come with the project."""
    from dp_tools.open_water.load import load_trial, trial_names

    table = Table("name", "title", "duration [s]".replace("[", r"\["), "source")
    for name in trial_names():
        trial = load_trial(name)
        table.add_row(name, trial.title, f"{trial.duration:g}", trial.source.replace("[", r"\["))
    console.print(table)


@open_water_app.command("check")
def check_trial(trial: TrialName) -> None:
    """Check a trial file; every problem is shown with file, line and field."""
    from dp_tools.open_water.load import load_trial

    found = load_trial(trial)
    console.print(f"{found.name}: valid, {len(found.cases)} cases of {found.duration:g} s", markup=False)


@open_water_app.command("run")
def run_trial_file(
    trial: TrialName,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder for page, numbers and series; open_water/<name> if left out."),
    ] = None,
) -> None:
    """Run a trial: compare its cases in a table, beside the thesis where it has numbers, and write page and series."""
    # The compiler behind it and plotting libraries load slowly; only these commands wait for them.
    from dp_tools.open_water.command import run_open_water
    from dp_tools.open_water.load import load_trial

    run_open_water(console, load_trial(trial), output)
