"""`dp design`: the design loop for a vessel."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console
from marine_model import load_vessel


def design(
    vessel: Annotated[
        str, typer.Argument(metavar="VESSEL", help="Vessel, by name or file; the thesis's example if left out.")
    ] = "cybership3_ch7",
    azimuth_degrees: Annotated[
        str,
        typer.Option(
            metavar="A,B,...",
            help="Directions of the azimuth thrusters in degrees, in the order of the vessel file, for the table with "
            "fixed directions; those of the vessel file if left out.",
        ),
    ] = "",
    maps: Annotated[
        bool, typer.Option("--map", metavar="", help="Draw maps of the minimum gain over two directions.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Folder for figures, CSV and JSON; with --map design/<vessel> if left out."
        ),
    ] = None,
) -> None:
    """Judge a thruster configuration: every combination of working thrusters, and every split into two power buses.

    Rank and minimum gain as in Tables 7.1 and 7.2 of the thesis, and beside them the largest ball of generalized force
    that is attainable.
    """
    chosen = load_vessel(vessel)
    # The compiler behind it and plotting libraries load slowly; only this command waits for them.
    from dp_tools.design.run import run_design

    run_design(console, chosen, azimuth_degrees, maps, output)
