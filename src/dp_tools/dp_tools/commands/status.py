"""`dp status`: vessel, thrusters, margins, nodes and alarms of a running graph on one screen."""

from __future__ import annotations

import json
import time
from typing import Annotated

import typer
from rich.console import Console
from rich.live import Live

from dp_bringup.graph_nodes import ANNOUNCEMENT_SECONDS, NODES
from dp_bringup.operator_node import NoAnswerError, Operator, operator
from dp_tools.commands.root import Namespace, console
from dp_tools.status.document import to_document
from dp_tools.status.keys import pressed_keys
from dp_tools.status.listener import StatusListener
from dp_tools.status.screen import WIDTH, fitting_height, render
from dp_tools.status.state import OUTPUTS, StatusState

_REFRESH = 0.25  # s
# Whoever has not been heard within this time is shown as missing.
_PATIENCE = 2.0 * ANNOUNCEMENT_SECONDS  # s


def status(
    once: Annotated[bool, typer.Option("--once", metavar="", help="Print one screen and end.")] = False,
    as_json: Annotated[bool, typer.Option("--json", metavar="", help="Print everything as JSON and end.")] = False,
    namespace: Namespace = "",
) -> None:
    """Show what vessel, thrusters and nodes are doing, live until Ctrl-C or q; a marks alarms as seen.

    If the output is not a terminal, one screen is printed, as with --once.
    """
    with operator(namespace) as one:
        state = StatusState(one.node.get_namespace())
        listener = StatusListener(one.node, state, time.time)
        _find(one, state, listener)
        if as_json or once or not console.is_terminal:
            _gather(one, state, listener)
            if as_json:
                typer.echo(json.dumps(to_document(state, time.time()), indent=2, allow_nan=False))
            else:
                print_screen(console, state, time.time())
            return
        try:
            _follow(one, state, listener)
        except KeyboardInterrupt:
            return


def print_screen(target: Console, state: StatusState, now: float) -> None:
    """Print one screen, as wide as the terminal and as high as it has to be."""
    width = max(target.width, WIDTH)
    height = fitting_height(state, now, width)
    wide = Console(file=target.file, width=width, height=height, force_terminal=target.is_terminal)
    wide.print(render(state, now, width, height), height=height)


def _find(one: Operator, state: StatusState, listener: StatusListener) -> None:
    """Wait until something of a graph is heard.

    Raises
    ------
    NoAnswerError
        If there is nothing below the namespace; graphs in other namespaces are named.
    """

    def heard() -> bool:
        listener.look()
        return state.known

    try:
        one.wait_until(heard, _PATIENCE, "a graph")
    except NoAnswerError as error:
        others = {space for name, space in one.node.get_node_names_and_namespaces() if name in NODES}
        others.discard(state.namespace)
        hint = f"there are nodes in {', '.join(sorted(others))}" if others else "is the graph running?"
        raise NoAnswerError(f"no graph in namespace {state.namespace}; {hint}") from error


def _gather(one: Operator, state: StatusState, listener: StatusListener) -> None:
    """Wait until every node has reported and its rate is known, or has had its time to."""

    def complete() -> bool:
        listener.look()
        reported = set(NODES) <= set(state.nodes) and state.vessel is not None
        return reported and state.pace is not None and all(state.rate(node) is not None for node in OUTPUTS)

    try:
        one.wait_until(complete, _PATIENCE, "reports of all nodes")
    except NoAnswerError:
        return  # what is missing is shown as missing


def _follow(one: Operator, state: StatusState, listener: StatusListener) -> None:
    """Show the screen until Ctrl-C or q."""
    with pressed_keys() as keys, Live(console=console, screen=True, auto_refresh=False) as live:
        while True:
            until = time.monotonic() + _REFRESH
            while time.monotonic() < until:
                one.executor.spin_once(timeout_sec=max(0.0, until - time.monotonic()))
            listener.look()
            pressed = keys()
            if "q" in pressed:
                return
            if "a" in pressed:
                state.alarms.acknowledge()
            live.update(render(state, time.time(), console.width, console.height), refresh=True)
