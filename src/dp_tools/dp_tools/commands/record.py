"""`dp record`: topics of a running graph to a bag."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer
from rclpy.parameter import Parameter
from rich.live import Live
from rich.text import Text

from dp_bringup.operator_node import full_namespace
from dp_tools.commands.root import Namespace, console, error_console
from dp_tools.recorder.compression import DEFAULT_COMPRESSION
from dp_tools.recorder.recorder_node import RecorderNode
from dp_tools.recorder.session import run

_MEGA = 1e6


class Compressed(StrEnum):
    """Compression of the chunks of a bag."""

    zstd = "zstd"
    lz4 = "lz4"
    none = "none"


Compression = Annotated[Compressed, typer.Option(help="Of the chunks of the bag.")]
DEFAULT = Compressed(DEFAULT_COMPRESSION)


def record(
    topics: Annotated[
        list[str] | None, typer.Argument(metavar="[TOPIC]...", help="Topics to record; all of the namespace if none.")
    ] = None,
    regex: Annotated[
        str, typer.Option("--regex", "-e", metavar="PATTERN", help="Also topics in whose name this is found.")
    ] = "",
    exclude: Annotated[
        str, typer.Option("--exclude", "-x", metavar="PATTERN", help="Never topics in whose name this is found.")
    ] = "",
    namespace: Namespace = "",
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FOLDER", help="Folder of the bag.")] = Path("bag"),
    overwrite: Annotated[bool, typer.Option("--overwrite", metavar="", help="Replace a bag that is there.")] = False,
    vessel: Annotated[str, typer.Option(metavar="NAME|FILE", help="Vessel to attach.")] = "",
    scenario: Annotated[str, typer.Option(metavar="FILE", help="Scenario file to attach.")] = "",
    compression: Compression = DEFAULT,
    max_size: Annotated[
        float, typer.Option(metavar="MB", help="Go on in another file at this size; 0 for never.", min=0.0)
    ] = 0.0,
    max_duration: Annotated[
        float, typer.Option(metavar="SECONDS", help="Go on in another file after so long; 0 for never.", min=0.0)
    ] = 0.0,
    duration: Annotated[
        float, typer.Option(metavar="SECONDS", help="End by itself after so long; 0 for never.", min=0.0)
    ] = 0.0,
) -> None:
    """Record topics to a bag (MCAP) until Ctrl-C.

    Topics are found as they appear, with the parameters of all nodes and every change of them.
    """
    full = full_namespace(namespace)
    values: dict[str, Any] = {
        "output": str(output),
        "overwrite": overwrite,
        "vessel": vessel,
        "scenario": scenario,
        "compression": compression.value,
        "max_size": max_size,
        "max_duration": max_duration,
        "duration": duration,
        "regex": regex,
        "exclude": exclude,
    }
    parameters = [Parameter(name, value=value) for name, value in values.items()]
    if topics:
        parameters.append(Parameter("topics", value=topics))
    with Live(console=console, transient=True, auto_refresh=False) as live:

        def tell(node: RecorderNode) -> None:
            live.update(progress_line(node), refresh=console.is_terminal)

        def say(text: str) -> None:
            live.console.print(text, markup=False, highlight=False, soft_wrap=True)

        def complain(text: str) -> None:
            error_console.print("[bold red]error:[/]", highlight=False, end=" ")
            error_console.print(text, markup=False, highlight=False, soft_wrap=True)

        code = run([], parameters, full, tell, say, complain)
    raise typer.Exit(code)


def progress_line(node: RecorderNode) -> Text:
    """Return how far a recording is, in one line."""
    writer, lost = node.writer, sum(node.recorder.lost.values())
    files = f" in {writer.file_count} files" if writer.file_count > 1 else ""
    line = Text(
        f"{writer.message_count} messages on {len(node.recorder.counts)} topics, {writer.size / _MEGA:.1f} MB{files}, "
    )
    return line.append(f"lost {lost}", style="bold red" if lost else "")
