"""`dp bag`: look into bags, check and repair them, cut them, turn them into tables."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

from dp_bringup.interrupts import Interrupts
from dp_tools.bags.bag import Bag
from dp_tools.bags.check import Checked, check_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.info import BagInfo, bag_info
from dp_tools.bags.repair import Repaired, repair
from dp_tools.bags.tables import write_tables
from dp_tools.bags.trim import trim as trim_bag
from dp_tools.commands.bag_options import (
    BagPath,
    Exclude,
    SimTime,
    Start,
    TimeOf,
    TimeOfOption,
    Topics,
    Until,
    warn_of_cut,
)
from dp_tools.commands.bag_progress import bag_size, bytes_bar, count_bar, reading
from dp_tools.commands.root import INTERRUPTED, console, error_console
from dp_tools.replay.selection import Selection

bag_app = typer.Typer()

Overwrite = Annotated[bool, typer.Option("--overwrite", metavar="", help="Replace what is there.")]


@bag_app.command()
def info(
    bag: BagPath,
    as_json: Annotated[bool, typer.Option("--json", metavar="", help="Print JSON.")] = False,
) -> None:
    """Show what is in a bag: time, size, topics, attachments, parameters, versions, what is missing."""
    with reading(bag) as opened:
        found = bag_info(opened)
    if as_json:
        everything = {**asdict(found), "size": found.size, "versions": found.versions}
        print(json.dumps(everything, indent=2))
    else:
        _show(found)


@bag_app.command()
def check(
    bag: BagPath,
    mend: Annotated[
        bool,
        typer.Option(
            "--repair", metavar="", help="Write what can be read as a whole bag; keep originals as *.damaged."
        ),
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="With --repair: leave the bag as it is, write the new one here."),
    ] = None,
) -> None:
    """Check a bag: structure, checksums, indexes, counts, times, lost messages, numbers that are none.

    Exit code 0 if nothing is wrong, or nothing is left wrong after a repair; 1 otherwise.
    """
    if output is not None and not mend:
        raise typer.BadParameter("--output needs --repair")
    checked = _check(bag)
    _tell(checked)
    if mend and checked.needs_repair:
        try:
            with Interrupts(), bytes_bar("repairing", bag_size(bag) if bag.exists() else 0) as progress:
                repaired = repair(bag, output, progress)
        except KeyboardInterrupt:
            raise typer.Exit(INTERRUPTED) from None
        _tell_of_repair(repaired)
        checked = _check(repaired.bag)
        _tell(checked)
    elif mend:
        console.print("nothing to repair")
    if not checked.whole:
        raise typer.Exit(1)


@bag_app.command()
def trim(
    bag: BagPath,
    output: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of the new bag.")],
    start: Start = None,
    until: Until = None,
    sim_time: SimTime = False,
    time_of: TimeOfOption = TimeOf.PUBLISH,
    topics: Topics = None,
    exclude: Exclude = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a part of a bag to a new one, with attachments, and latched messages and parameters as at the start."""
    with reading(bag) as opened:
        warn_of_cut(opened)
        names = _names(opened, topics, exclude)
        with count_bar("writing", len(opened.messages)) as progress:
            done = trim_bag(opened, output, names, time_of.value, start, until, sim_time, overwrite, progress)
    carried = f", {', '.join(done.carried)} from before the start" if done.carried else ""
    nodes = f", parameters of {len(done.nodes)} nodes" if done.nodes else ""
    console.print(f"bag     {output}: {done.messages} messages{carried}{nodes}", highlight=False, soft_wrap=True)


@bag_app.command("to-csv")
def to_csv(
    bag: BagPath,
    output: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder; BAG_csv if left out.")] = None,
    topics: Topics = None,
    exclude: Exclude = None,
    overwrite: Overwrite = False,
) -> None:
    """Write one CSV file a topic: one line a message, one column a field, units from the message definitions."""
    _write_tables(bag, output, "csv", topics, exclude, overwrite)


@bag_app.command("to-parquet")
def to_parquet(
    bag: BagPath,
    output: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder; BAG_parquet if left out.")] = None,
    topics: Topics = None,
    exclude: Exclude = None,
    overwrite: Overwrite = False,
) -> None:
    """Write one Parquet file a topic: one row a message, one column a field, units as metadata of the columns."""
    _write_tables(bag, output, "parquet", topics, exclude, overwrite)


def _names(bag: Bag, topics: Sequence[str] | None, exclude: Sequence[str] | None) -> dict[str, str]:
    return Selection(topics or (), exclude or ()).names(topic.name for topic in bag.topics)


def _write_tables(
    bag: Path,
    output: Path | None,
    kind: str,
    topics: Sequence[str] | None,
    exclude: Sequence[str] | None,
    overwrite: bool,
) -> None:
    with reading(bag) as opened:
        warn_of_cut(opened)
        names = _names(opened, topics, exclude)
        folder = output or opened.files.path.absolute().with_name(f"{opened.files.path.absolute().stem}_{kind}")
        with count_bar("writing", len(opened.messages)) as progress:
            written = write_tables(opened, names, folder, kind == "parquet", overwrite, progress)
    table = Table("topic", "file")
    for title in ("rows", "columns"):
        table.add_column(title, justify="right")
    for name, path, rows, columns in written:
        table.add_row(name, path.name, str(rows), str(columns))
    console.print(table)
    console.print(f"folder  {folder}", highlight=False, soft_wrap=True)
    if not written:
        raise BagError(f"{opened.files.path}: no message on these topics")


def _check(path: Path) -> Checked:
    with bytes_bar("checking", bag_size(path)) as progress:
        return check_bag(path, progress)


def _tell(checked: Checked) -> None:
    for finding in (*checked.structure, *checked.content):
        colour, word = ("red", "wrong") if finding.wrong else ("yellow", "note ")
        console.print(f"[{colour}]{word}[/]   {escape(str(finding))}", highlight=False, soft_wrap=True)
    verdict = "whole" if checked.whole else "not whole"
    console.print(f"{verdict}: {checked.messages} messages can be read", highlight=False)


def _tell_of_repair(done: Repaired) -> None:
    for name, count in done.messages.items():
        console.print(f"repaired {name}: {count} messages recovered", highlight=False, soft_wrap=True)
    for path in done.kept:
        console.print(f"kept    {path}", highlight=False, soft_wrap=True)
    console.print(f"bag     {done.bag}", highlight=False, soft_wrap=True)


def _show(found: BagInfo) -> None:
    grid = Table.grid(padding=(0, 2))
    for name, value in _facts(found):
        grid.add_row(name, escape(value))
    console.print(grid)
    for text in found.unfinished:
        error_console.print(f"warning: {text}", markup=False, highlight=False, soft_wrap=True)
    table = Table()
    table.add_column("topic", overflow="fold")
    table.add_column("type", overflow="fold")
    for title in ("messages", "Hz", "lost"):
        table.add_column(title, justify="right")
    table.add_column("offered", overflow="fold")
    for topic in found.topics:
        rate = f"{topic.rate:.3g}" if topic.rate is not None else ""
        lost = "" if topic.lost is None else str(topic.lost)
        kind = topic.type.replace("/msg/", "/")
        table.add_row(topic.name, kind, str(topic.messages), rate, lost, topic.quality)
    console.print(table)


def _facts(found: BagInfo) -> list[tuple[str, str]]:
    ratio = f", {found.uncompressed_size / found.size:.1f} times that unpacked" if found.size else ""
    compression = ", ".join(f"{name} ({count} chunks)" for name, count in found.compression.items()) or "none"
    facts = [
        ("bag", found.path),
        ("files", ", ".join(f"{name} ({size / 1e6:.2f} MB)" for name, size in found.files.items())),
        ("size", f"{found.size / 1e6:.2f} MB{ratio}; compression {compression}"),
        ("begin", f"{found.begin_utc} ({found.begin:.3f})" if found.begin is not None else "no message"),
        ("duration", f"{found.duration:.3f} s"),
        ("messages", f"{found.messages} on {len(found.topics)} topics; lost: {found.lost_messages}"),
        ("vessel", found.vessel or "not told"),
        ("scenario", found.scenario or "none"),
        ("versions", ", ".join(f"{name} {version}" for name, version in found.versions.items()) or "not told"),
        ("attachments", ", ".join(f"{one['name']} ({one['size']} bytes)" for one in found.attachments) or "none"),
    ]
    for node, own in found.parameters.items():
        if "error" in own:
            facts.append(("parameters", own["error"]))
        else:
            text = f"{own['parameters']} taken {own['snapshots']} times, changed {own['changes']} times"
            facts.append((f"parameters {node}", text))
    facts += [(name, value) for name, value in found.custom_data.items() if name in ("stopped", "repaired", "trimmed")]
    return facts
