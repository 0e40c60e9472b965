"""The table of all runs in the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from dp_tools.campaign.index import Entry

# Columns of a table in a file or a pipe, which have no width of their own.
_WIDTH_OF_A_FILE = 160
_STYLES = {True: "green", False: "bold red", None: ""}


def print_tables(entries: Sequence[Entry]) -> None:
    """Print both tables."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=_WIDTH_OF_A_FILE)
    console.print(figure_table(entries))
    console.print(run_table(entries))


def figure_table(entries: Sequence[Entry]) -> Table:
    """Return run, figure, thesis, ours, interval and verdict of every figure."""
    table = Table(title="Figures of merit", title_justify="left")
    for name in ("run", "figure"):
        table.add_column(name, overflow="fold")
    for name in ("thesis", "ours", "95 % interval"):
        table.add_column(name, justify="right")
    table.add_column("verdict")
    for entry in entries:
        for i, line in enumerate(entry.lines()):
            cells = [entry.summary.run if i == 0 else "", line.title, line.thesis, line.ours, line.interval]
            table.add_row(*map(Text, cells), Text(line.verdict, _STYLES[line.good]))
        table.add_section()
    return table


def run_table(entries: Sequence[Entry]) -> Table:
    """Return who sailed every run, its fingerprint, and how far graph and in process are apart if that is known."""
    compared = any(entry.summary.apart is not None for entry in entries)
    table = Table("run", "sailed", "fingerprint", *(["graph from in process"] if compared else []))
    for entry in entries:
        cells = [Text(entry.summary.run), Text(entry.facts), Text(entry.fingerprint)]
        if compared:
            cells.append(Text(entry.apart, _STYLES[entry.agrees]))
        table.add_row(*cells)
    return table
