"""`dp scenario`: scenarios that can be played."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from dp_tools.commands.root import console
from dp_tools.commands.run_scenarios import run
from dp_tools.scenario import load_scenario, scenario_names

scenario_app = typer.Typer()
scenario_app.command("run")(run)


@scenario_app.command("list")
def list_scenarios() -> None:
    """List the scenarios that come with the project."""
    table = Table("name", "title", "vessel", "duration [s]".replace("[", r"\["), "source")
    for name in scenario_names():
        scenario = load_scenario(name)
        table.add_row(name, scenario.title, scenario.vessel, f"{scenario.duration:g}", scenario.source)
    console.print(table)


@scenario_app.command("check")
def check_scenario(scenario: Annotated[str, typer.Argument(metavar="NAME|FILE", help="Scenario.")]) -> None:
    """Check a scenario file; every problem is shown with file, line and field."""
    found = load_scenario(scenario)
    console.print(f"{found.name}: valid, {len(found.events)} events in {found.duration:g} s", markup=False)
