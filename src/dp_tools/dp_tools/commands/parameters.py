"""`dp param`: parameters of running nodes."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer
import yaml
from rcl_interfaces.msg import ParameterDescriptor, ParameterType
from rich.markup import escape
from rich.table import Table

from dp_bringup.graph_nodes import ANNOUNCEMENT_SECONDS, NODES, present
from dp_bringup.operator_node import NoAnswerError, Operator, operator
from dp_bringup.parameter_file import read_parameter_file, to_parameter_file, yaml_value
from dp_bringup.parameter_service import RemoteParameters
from dp_tools.commands.root import Namespace, console
from marine_model import load_vessel
from marine_model.yaml_document import parse_value

parameters_app = typer.Typer()

NodeName = Annotated[str, typer.Argument(metavar="NODE", help="Node, e.g. thrust_allocator.")]
_TYPES = {
    getattr(ParameterType, name): name.removeprefix("PARAMETER_").lower()
    for name in dir(ParameterType)
    if name.startswith("PARAMETER_")
}


@parameters_app.command("list")
def list_parameters(
    node: Annotated[str, typer.Argument(metavar="NODE", help="All of the graph if left out.")] = "",
    namespace: Namespace = "",
) -> None:
    """List parameters with value, range or type, and meaning."""
    with operator(namespace) as one:
        for name in [node] if node else _running(one):
            remote = RemoteParameters(one, name)
            values = remote.get()
            descriptors = remote.describe(list(values))
            table = Table(title=name, title_justify="left")
            table.add_column("parameter", no_wrap=True)
            table.add_column("value", overflow="fold")
            table.add_column("range")
            table.add_column("meaning")
            for parameter, value in values.items():
                descriptor = descriptors[parameter]
                meaning = f"{descriptor.description}{'; read-only' if descriptor.read_only else ''}"
                limits = _range(descriptor) or _TYPES[descriptor.type]
                table.add_row(parameter, *(escape(text) for text in (_text(value), limits, meaning)))
            console.print(table)


@parameters_app.command()
def get(
    node: NodeName,
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="Parameters.")],
    namespace: Namespace = "",
) -> None:
    """Print values, one a line."""
    with operator(namespace) as one:
        for name, value in RemoteParameters(one, node).get(names).items():
            console.print(f"{name}: {_text(value)}", markup=False, highlight=False)


@parameters_app.command("set", context_settings={"ignore_unknown_options": True})
def set_parameters(
    node: NodeName,
    pairs: Annotated[list[str], typer.Argument(metavar="NAME VALUE...", help="Pairs; values in YAML.")],
    namespace: Namespace = "",
) -> None:
    """Set parameters of one node, all or none; a refusal gives the node's reason."""
    if len(pairs) % 2:
        raise typer.BadParameter("expected NAME VALUE pairs, found an odd number of words")
    values = {name: parse_value(text) for name, text in zip(pairs[::2], pairs[1::2], strict=True)}
    with operator(namespace) as one:
        RemoteParameters(one, node).set(values)
    for name, value in values.items():
        console.print(f"{node}: {name} = {_text(value)}", markup=False, highlight=False)


@parameters_app.command()
def dump(
    nodes: Annotated[list[str] | None, typer.Argument(metavar="NODE...", help="All of the graph if left out.")] = None,
    output: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write; standard output if left out.")
    ] = None,
    namespace: Namespace = "",
) -> None:
    """Write all parameters as a ROS parameter file (for --params-file, ros2 param load, dp param load)."""
    with operator(namespace) as one:
        text = to_parameter_file({name: RemoteParameters(one, name).get() for name in nodes or _running(one)})
    if output is None:
        typer.echo(text, nl=False)
    else:
        output.write_text(text, encoding="utf-8")


@parameters_app.command()
def load(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="ROS parameter file.")], namespace: Namespace = ""
) -> None:
    """Set the parameters of a file, node by node, each node's all or none; read-only ones must agree."""
    values = read_parameter_file(file)
    with operator(namespace) as one:
        for node, own in values.items():
            changed = RemoteParameters(one, node).set_changeable(own)
            console.print(f"{node}: set {len(changed)} parameters")


@parameters_app.command()
def diff(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="ROS parameter file.")], namespace: Namespace = ""
) -> None:
    """Compare a file with the running nodes; exit code 1 if a value differs."""
    values = read_parameter_file(file)
    differing = 0
    with operator(namespace) as one:
        for node, own in values.items():
            present = RemoteParameters(one, node).get(list(own))
            for name, value in own.items():
                if present[name] != value:
                    differing += 1
                    line = f"{node}: {name}: file {yaml_value(value)}, node {yaml_value(present[name])}"
                    console.print(line, markup=False, highlight=False)
    if differing:
        raise typer.Exit(1)


@parameters_app.command()
def template(
    node: NodeName,
    vessel: Annotated[str, typer.Option(metavar="VESSEL", help="Name or file of the vessel.")] = "cybership3",
    output: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write; standard output if left out.")
    ] = None,
) -> None:
    """Write a parameter file of one node with every default, unit and meaning; needs no running graph."""
    # Here: it loads the core of every node, and with it the compiler.
    from dp_tools.parameter_template import parameter_template

    text = parameter_template(node, vessel, load_vessel(vessel))
    if output is None:
        typer.echo(text, nl=False)
    else:
        output.write_text(text, encoding="utf-8")


def _running(one: Operator) -> list[str]:
    """Return the nodes of the graph that are there: all, or those that have announced themselves by now."""
    with suppress(NoAnswerError):
        one.wait_until(lambda: set(present(one)) == set(NODES), 1.5 * ANNOUNCEMENT_SECONDS, "the whole graph")
    found = sorted(set(present(one)))
    if not found:
        raise NoAnswerError(f"no node of the graph in namespace {one.node.get_namespace()}; is it running?")
    return found


def _text(value: Any) -> str:
    return yaml.safe_dump(value, default_flow_style=True).strip().removesuffix("...").strip()


def _range(descriptor: ParameterDescriptor) -> str:
    for limits in (*descriptor.floating_point_range, *descriptor.integer_range):
        low = "" if abs(limits.from_value) > 1e300 else f"{limits.from_value:g}"
        high = "" if abs(limits.to_value) > 1e300 else f"{limits.to_value:g}"
        return f"{low} .. {high}"
    return ""
