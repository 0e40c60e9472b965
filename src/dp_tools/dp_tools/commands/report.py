"""`dp report`: a report from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console


def report(
    bag: Annotated[Path, typer.Argument(metavar="BAG", help="Folder of a recording, or its .mcap file.")],
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder for report.html and figures.json; beside the bag if left out."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write one PNG with position, directions and power as well, e.g. for a page."
        ),
    ] = None,
    vessel: Annotated[str, typer.Option(metavar="NAME|FILE", help="Vessel, for a recording that holds none.")] = "",
) -> None:
    """Write report.html and figures.json from a recording."""
    write_and_tell(bag, output or bag.absolute().parent, picture, vessel)


def write_and_tell(bag: Path, folder: Path, picture: Path | None = None, vessel: str = "") -> None:
    """Write the report, and the picture if one is asked for, and print where they are."""
    # Plotting libraries load slowly; only this command waits for them.
    from dp_tools.report import report_bag

    with console.status("writing report"):
        page, figures = report_bag(bag, folder, vessel, picture)
    console.print(f"report  {page}", soft_wrap=True)
    console.print(f"figures {figures}", soft_wrap=True)
    if picture is not None:
        console.print(f"picture {picture}", soft_wrap=True)
