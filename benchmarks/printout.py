"""The figures on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.result import Result


def print_machine(console: Console, machine: Mapping[str, Any]) -> None:
    """Print what the figures are measured on."""
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    console.print(
        f"{machine['cpu']}, {machine['usable_cores']} of {machine['logical_cores']} cores, "
        f"{machine['memory_bytes'] / 1e9:.1f} GB, load {machine['load_average_1_min_before']:.1f} before; "
        f"Linux {machine['kernel']}, Python {machine['python']}, {versions}",
        highlight=False,
    )


def print_results(console: Console, title: str, results: Sequence[Result]) -> None:
    """Print the figures of one measurement, each with its note below."""
    table = Table(title=title, title_justify="left")
    for header, side in (
        ("figure", "left"),
        ("value", "right"),
        ("unit", "left"),
        ("peer", "left"),
        ("peer value", "right"),
        ("ratio", "right"),
        ("aim", "left"),
        ("met", "left"),
    ):
        table.add_column(
            header, justify="right" if side == "right" else "left", overflow="fold", no_wrap=header == "figure"
        )
    for result in results:
        table.add_row(
            result.name,
            _number(result.value),
            result.unit,
            result.peer or "",
            _number(result.peer_value),
            _number(result.ratio),
            "" if result.aim is None else str(result.aim),
            {None: "", True: "[green]yes[/]", False: "[red]no[/]"}[result.met],
        )
    console.print(table)
    for result in results:
        if result.note:
            console.print(f"  {result.name}: {result.note}", highlight=False, soft_wrap=True)


def _number(value: float | None) -> str:
    """Return three significant digits, and an exponent only where there would be none of them."""
    if value is None:
        return ""
    if 0.0 < abs(value) < 0.01:
        return f"{value:.1e}"
    digits = 0 if abs(value) >= 100.0 else 1 if abs(value) >= 10.0 else 2
    return f"{value:.{digits}f}"
