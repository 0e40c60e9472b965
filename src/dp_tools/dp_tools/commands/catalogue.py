"""The commands by name, and what the list of them says: known without loading what they work with."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import typer
import typer.main
from typer.core import TyperGroup


@dataclass(frozen=True)
class Entry:
    """One command, or one group of commands.

    Attributes
    ----------
    module, attribute
        Where the function or the ``typer.Typer`` is.
    text
        What it does, in a line: of a function, the first paragraph of its docstring.
    """

    module: str
    attribute: str
    text: str


ENTRIES = {
    "up": Entry("up", "up", "Start the graph, play a scenario if one is given, and stop everything in the end."),
    "record": Entry("record", "record", "Record topics to a bag (MCAP) until Ctrl-C."),
    "replay": Entry(
        "replay",
        "replay",
        "Publish the messages of a bag again: as they were serialized, in their order, at their times.",
    ),
    "report": Entry(
        "report",
        "report",
        "Write report.html and figures.json from a recording; from several, index.html and index.json with one table.",
    ),
    "status": Entry(
        "status",
        "status",
        "Show what vessel, thrusters and nodes are doing, live until Ctrl-C or q; a marks alarms as seen.",
    ),
    "topics": Entry(
        "topics", "topics", "List topics with type, publishers and subscribers; in a namespace only those below it."
    ),
    "restart": Entry(
        "restart",
        "restart",
        "Restart a node with its last parameters, or one that was given up; in a composed graph, all of them.",
    ),
    "design": Entry(
        "design",
        "design",
        "Judge a thruster configuration: every combination of working thrusters, and every split into two power buses.",
    ),
    "compare": Entry(
        "compare",
        "compare",
        "Show what published allocation methods give away against the exact attainable set and the quadratic program.",
    ),
    "propeller": Entry(
        "propeller",
        "propeller",
        "Look at propellers: open-water curves, efficiency over (tau, P/D), optimal paths, controllers, ventilation.",
    ),
    "detection": Entry(
        "detection",
        "detection",
        "Count what ventilation detection finds and misses: simulated events, and a moderate sea without any.",
    ),
    "disturb": Entry(
        "disturb",
        "disturb",
        "Sail a scenario in process with one fault of the pose after the other, and compare with none.",
    ),
    "bag": Entry("bag", "bag_app", "Look into recordings, check and repair them, cut them, make tables."),
    "param": Entry("parameters", "parameters_app", "Read and change parameters of running nodes."),
    "scenario": Entry("scenarios", "scenario_app", "Scenarios: list, check, sail and judge them."),
    "vessel": Entry("vessels", "vessel_app", "Vessels: list them, check a file, scale one."),
    "open-water": Entry(
        "open_water", "open_water_app", "One thruster by itself in a basin, and several ways to control it compared."
    ),
}


class LazyGroup(TyperGroup):
    """A group that loads a command when it is called; the list of commands is :data:`ENTRIES`."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Put the command itself in the place of its name, then go on as ever."""
        if args and args[0] in ENTRIES:
            self.commands[args[0]] = load(args[0])
        return super().resolve_command(ctx, args)


def load(name: str) -> Any:
    """Return the command of this name, ready to be called."""
    entry = ENTRIES[name]
    found = getattr(import_module(f"dp_tools.commands.{entry.module}"), entry.attribute)
    holder = typer.Typer(add_completion=False)
    if isinstance(found, typer.Typer):
        holder.add_typer(found, name=name, help=entry.text, no_args_is_help=True)
    else:
        holder.command(name)(found)
    return typer.main.get_group(holder).commands[name]


def fill(app: typer.Typer) -> None:
    """Put the names of all commands into ``app``, which is to be a :class:`LazyGroup`."""
    for name, entry in ENTRIES.items():
        app.command(name, help=entry.text)(_not_loaded)


def _not_loaded() -> None:
    raise NotImplementedError("a command is called before it is loaded")
