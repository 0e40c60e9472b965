"""Opening a bag with a bar, as a large one takes some seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.progress import BarColumn, DownloadColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from dp_tools.bags.bag import Bag, open_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.files import bag_files
from dp_tools.commands.root import error_console


@contextmanager
def reading(path: Path) -> Iterator[Bag]:
    """Open a bag; a bar shows how far it has been read. Raises BagError."""
    with bytes_bar("reading", bag_size(path)) as progress:
        opened = open_bag(path, progress)
    with opened:
        yield opened


def bag_size(path: Path) -> int:
    """Return the bytes in the MCAP files of a bag. Raises BagError."""
    try:
        return sum(file.stat().st_size for file in bag_files(path).files)
    except OSError as error:
        raise BagError(f"{path}: cannot be read: {error.strerror or error}") from error


@contextmanager
def bytes_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar of bytes on a terminal; it goes away in the end."""
    with _bar(DownloadColumn()) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.update(task, completed=done)


@contextmanager
def count_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar of numbers on a terminal; it goes away in the end."""
    with _bar(MofNCompleteColumn()) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.update(task, completed=done)


def _bar(column: DownloadColumn | MofNCompleteColumn) -> Progress:
    columns = (TextColumn("{task.description:<10}"), BarColumn(), column, TimeRemainingColumn())
    return Progress(*columns, console=error_console, transient=True, disable=not error_console.is_terminal)
