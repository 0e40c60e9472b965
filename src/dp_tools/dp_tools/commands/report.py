"""`dp report`: a report from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console


def report(
    bag: Annotated[Path, typer.Argument(help="Folder of a recording, or its .mcap file.")],
    output: Annotated[
        Path | None, typer.Option(help="Folder for report.html and figures.json; beside the bag if left out.")
    ] = None,
) -> None:
    """Write report.html and figures.json from a recording."""
    write_and_tell(bag, output or bag.absolute().parent)


def write_and_tell(bag: Path, folder: Path) -> None:
    """Write the report and print where it is."""
    # Plotting libraries load slowly; only this command waits for them.
    from dp_tools.report import report_bag

    with console.status("writing report"):
        page, figures = report_bag(bag, folder)
    console.print(f"report  {page}", soft_wrap=True)
    console.print(f"figures {figures}", soft_wrap=True)
