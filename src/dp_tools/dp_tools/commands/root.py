"""The command itself: its name, its help, and what an error looks like."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console

from dp_tools.commands.catalogue import LazyGroup

console = Console()
error_console = Console(stderr=True)

INTERRUPTED = 130  # as shells say for a command that Ctrl-C ended

Namespace = Annotated[str, typer.Option(metavar="NAME", help="Namespace of the graph.")]

app = typer.Typer(
    name="dp",
    cls=LazyGroup,
    help="Run, steer, record and report on the dynamic-positioning graph.",
    no_args_is_help=True,
    # It would write to the user's shell files.
    add_completion=False,
    pretty_exceptions_show_locals=False,
)


def main() -> None:
    """Run the command; an error of ours is plain text and exit code 1, never a traceback."""
    try:
        app()
    except Exception as error:
        # Here: the vocabulary of the stack loads slowly, and whatever raises this has loaded it.
        from marine_model.errors import DpError

        if not isinstance(error, DpError):
            raise
        error_console.print("[bold red]error:[/]", highlight=False, end=" ")
        error_console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
