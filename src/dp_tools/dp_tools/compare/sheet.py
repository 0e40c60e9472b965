"""A table with its title and a remark, for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rich.markup import escape
from rich.table import Table

from dp_tools.quantities import number

Row = tuple[str, tuple[str, ...]]


@dataclass(frozen=True)
class Sheet:
    """Rows of text.

    Attributes
    ----------
    title
        Above it.
    head
        Names of the columns behind the first.
    rows
        Name of each row, and its cells.
    note
        What to read out of it.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""

    def table(self) -> Table:
        """Return it for the terminal."""
        table = Table(title=escape(self.title), title_justify="left")
        table.add_column("")
        for name in self.head:
            table.add_column(escape(name), justify="right")
        for name, cells in self.rows:
            table.add_row(escape(name), *map(escape, cells))
        return table


def percent(share: float) -> str:
    """Return a share, e.g. '16.7 %'."""
    return f"{100.0 * share:.1f} %"


def figures(values: Iterable[float], digits: int = 4) -> str:
    """Return an array of numbers with commas between them."""
    return ", ".join(number(float(value), digits) for value in values)
