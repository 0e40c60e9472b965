"""`dp compare`: what allocation methods give away on a vessel."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console
from marine_model import load_vessel


def compare(
    vessel: Annotated[str, typer.Argument(metavar="VESSEL", help="Vessel, by name or file.")],
    demands: Annotated[int, typer.Option(metavar="N", help="Random demands for each part.")] = 10000,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the random demands.")] = 1,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder for page, JSON and pictures; compare/<vessel> if left out."),
    ] = None,
) -> None:
    """Show what published allocation methods give away against the exact attainable set and the quadratic program.

    Octahedron and priority for every group of coupled axes, the asteroid of four azimuth propellers that turn together,
    portions of a cross of marching thrusters, and drives that take codes with and without compensation for the speed,
    as far as the vessel has such thrusters.
    """
    chosen = load_vessel(vessel)
    # Plotting libraries load slowly; only this command waits for them.
    from dp_tools.compare.run import run_compare

    run_compare(console, chosen, demands, seed, output)
