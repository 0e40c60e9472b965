"""`dp disturb`: pose faults, one after the other, and what the vessel makes of them."""

from __future__ import annotations

import math
from typing import Annotated

import typer
from rich.table import Table

from dp_tools.commands.root import console
from dp_tools.disturber.campaign import campaign, voyage
from dp_tools.scenario import load_scenario
from marine_model import load_vessel


def disturb(
    scenario: Annotated[str, typer.Argument(metavar="NAME|FILE", help="Scenario whose start is sailed.")] = "run_a",
) -> None:
    """Sail a scenario in process with one fault of the pose after the other, and compare with none.

    In the graph `ros2 run dp_tools disturber` makes the same faults.
    """
    chosen = load_scenario(scenario)
    table = Table("fault", "off max, m", "rms, m", "heading, deg", "back after, s", "refused", "shown", "after, s")
    with console.status("sailing") as status:
        found = campaign(load_vessel(chosen.vessel), voyage(chosen), lambda name: status.update(f"sailing: {name}"))
        for row in found:
            table.add_row(
                row.name,
                f"{row.largest:.3f}",
                f"{row.rms:.3f}",
                f"{math.degrees(row.heading):.1f}",
                "not in the run" if row.recovery is None else f"{row.recovery:.1f}",
                str(row.refused),
                ", ".join(row.shown) or "-",
                "-" if row.shown_after is None else f"{row.shown_after:.1f}",
            )
    console.print(table)
