"""What commands that read a bag have in common: their options, and what is said of a bag that was cut off."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from dp_tools.bags.bag import Bag
from dp_tools.commands.root import error_console


class TimeOf(StrEnum):
    """Which time of a message says when it is sent."""

    PUBLISH = "publish"
    LOG = "log"


BagPath = Annotated[Path, typer.Argument(metavar="BAG", help="Folder of a bag or of a run, or one MCAP file.")]
Start = Annotated[float | None, typer.Option(metavar="SECONDS", help="From here on, counted from the first message.")]
Until = Annotated[float | None, typer.Option(metavar="SECONDS", help="Up to here, counted from the first message.")]
SimTime = Annotated[
    bool, typer.Option("--sim-time", metavar="", help="--start and --until are simulated time, by the bag's clock.")
]
TimeOfOption = Annotated[
    TimeOf, typer.Option("--time", help="By the time at which messages were published, or were recorded.")
]
Topics = Annotated[
    list[str] | None, typer.Option(metavar="TOPIC", help="Only these topics (* and ? allowed); repeatable.")
]
Exclude = Annotated[
    list[str] | None, typer.Option(metavar="TOPIC", help="Not these topics (* and ? allowed); repeatable.")
]


def warn_of_cut(bag: Bag) -> None:
    """Say of every file of a bag that ends too early that it does."""
    for path, error in bag.cut_off.items():
        warn(f"{path}: the recording was not closed; the bag ends where the file does ({error})")


def warn(text: str) -> None:
    """Say what the operator should know; the command goes on."""
    error_console.print(f"warning: {text}", markup=False, highlight=False, soft_wrap=True)
