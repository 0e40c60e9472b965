"""What verification found, as tables in the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rich.console import Console
from rich.table import Table

from dp_tools.reexecution.comparison import FieldDifference, Spot, TopicComparison
from dp_tools.reexecution.fields import Value

# First difference of a field; in how many messages; the largest of them, and when.
_COLUMNS = ("topic", "field", "message", "time", "in bag", "recorded", "found", "differ", "largest", "at")
# Numbers are shown to the last digit, however wide the terminal is.
_WIDTH = 240


def verdict_table(name: str, comparisons: Iterable[TopicComparison], not_recorded: Iterable[str]) -> Table:
    """Return one line a topic: how many messages, and how many of them are the same."""
    table = Table(title=name, title_justify="left", box=None, pad_edge=False)
    for column in ("recorded", "found", "same", "missing", "extra", "differ"):
        if column == "recorded":
            table.add_column("topic")
        table.add_column(column, justify="right")
    for one in comparisons:
        pairs = one.recorded - len(one.missing)
        table.add_row(
            one.topic,
            *map(str, (one.recorded, one.found, one.same, len(one.missing), len(one.extra), pairs - one.same)),
            style="" if one.agrees else "red",
        )
    for topic in not_recorded:
        table.add_row(topic, "not recorded", *[""] * 5, style="dim")
    return table


def difference_table(comparisons: Iterable[TopicComparison]) -> Table:
    """Return one line a field that differs: the first difference, the largest, and in how many messages."""
    table = Table(box=None, pad_edge=False)
    for column in _COLUMNS:
        table.add_column(column, justify="left" if column in _COLUMNS[:2] else "right", no_wrap=True)
    for one in comparisons:
        for spot, count in ((one.missing_from, len(one.missing)), (one.extra_from, len(one.extra))):
            if spot is not None:
                table.add_row(one.topic, *_spot(spot), str(count), "", "")
        for difference in one.fields.values():
            table.add_row(one.topic, *_spot(difference.first), str(difference.count), *_largest(difference))
    return table


def show(console: Console, title: str, comparisons: list[TopicComparison], not_recorded: Iterable[str]) -> None:
    """Print what was found of one node."""
    console.print(verdict_table(title, comparisons, not_recorded))
    if not all(one.agrees for one in comparisons):
        console.print(difference_table(comparisons), width=_WIDTH, crop=False, soft_wrap=True, no_wrap=True)


def _spot(spot: Spot) -> tuple[str, ...]:
    return (
        spot.path,
        str(spot.index),
        f"{spot.simulated:.3f} s",
        f"{spot.bag:.3f} s",
        _value(spot.recorded),
        _value(spot.found),
    )


def _largest(difference: FieldDifference) -> tuple[str, str]:
    size = difference.largest.size
    return ("" if math.isinf(size) else f"{size:.6g}", f"{difference.largest.simulated:.3f} s")


def _value(value: Value | None) -> str:
    """Return a value so that two that differ look different."""
    return repr(value) if isinstance(value, float) else str(value)
