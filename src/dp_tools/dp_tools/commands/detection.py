"""`dp detection`: how well the drivers of a vessel find ventilation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console
from marine_model import load_vessel


def detection(
    vessel: Annotated[str, typer.Argument(metavar="VESSEL", help="Vessel, by name or file.")] = "cybership3",
    duration: Annotated[
        float,
        typer.Option(
            metavar="S", min=60.0, max=36000.0, help="Time of moderate sea, in s; half as much of ventilation."
        ),
    ] = 3600.0,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of both.")] = 1,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder for page and numbers; detection/<vessel> if left out."),
    ] = None,
) -> None:
    """Count what ventilation detection finds and misses: simulated events, and a moderate sea without any."""
    chosen = load_vessel(vessel)
    # The compiler behind it and plotting libraries load slowly; only this command waits for them.
    from dp_tools.detection_report.command import run_detection

    run_detection(console, chosen, duration, seed, output)
