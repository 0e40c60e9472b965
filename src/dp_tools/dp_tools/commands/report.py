"""`dp report`: a report from a recording, or one table from many."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console
from dp_tools.run_folder import RunFolder


def report(
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="BAG|FOLDER...",
            help="A recording (its folder or .mcap file); or several, or a folder of runs, for one table of all.",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder for what is written; beside the bag, in the folder of runs, or in runs if left out.",
        ),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write one PNG with position, directions and power as well, e.g. for a page."
        ),
    ] = None,
    vessel: Annotated[str, typer.Option(metavar="NAME|FILE", help="Vessel, for a recording that holds none.")] = "",
) -> None:
    """Write report.html and figures.json from a recording; from several, index.html and index.json with one table."""
    if len(paths) == 1 and _is_recording(paths[0]):
        write_and_tell(paths[0], output or paths[0].absolute().parent, picture, vessel)
        return
    if picture is not None or vessel:
        raise typer.BadParameter("--picture and --vessel are for the report of one recording")
    alone = len(paths) == 1 and not RunFolder(paths[0]).bag.is_dir()
    index_and_tell(paths, output or (paths[0] if alone else Path("runs")))


def _is_recording(path: Path) -> bool:
    """Return whether this is a bag, or nothing at all, which the reader of bags then says."""
    return not path.is_dir() or any(path.glob("*.mcap"))


def index_and_tell(paths: Sequence[Path], folder: Path) -> None:
    """Write the table of all runs, print it, and say where it is."""
    from dp_tools.campaign.index import INDEX_DATA_NAME, find_entries
    from dp_tools.campaign.page import write_index
    from dp_tools.campaign.terminal import print_tables

    with console.status("reading runs"):
        entries = find_entries(paths, folder.absolute())
        page = write_index(folder.absolute(), entries)
    print_tables(entries)
    console.print(f"index   {page}", soft_wrap=True)
    console.print(f"data    {page.parent / INDEX_DATA_NAME}", soft_wrap=True)


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
