"""`dp vessel`: the vessels there are, and others made of them."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from dp_tools.commands.root import console
from dp_tools.run_folder import FolderError
from marine_model import load_vessel
from marine_model.froude import scaled
from marine_model.load import vessel_names
from marine_model.section_text import section_text

vessel_app = typer.Typer()

_Vessel = Annotated[str, typer.Argument(metavar="VESSEL", help="Vessel, by name or file.")]


@vessel_app.command("list")
def list_vessels() -> None:
    """List the vessels that come with the project."""
    table = Table("name", "length [m]".replace("[", r"\["), "scale", "thrusters", "description")
    for name in vessel_names():
        vessel = load_vessel(name)
        length, n = f"{vessel.hull.length:g}", str(len(vessel.thrusters))
        table.add_row(name, length, f"1:{vessel.scale:g}", n, vessel.description)
    console.print(table)


@vessel_app.command("check")
def check_vessel(vessel: _Vessel) -> None:
    """Check a vessel file; every problem is shown with file, line and field."""
    found = load_vessel(vessel)
    console.print(f"{found.name}: valid, {len(found.thrusters)} thrusters, {found.hull.length:g} m", markup=False)


@vessel_app.command("scale")
def scale_vessel(
    vessel: _Vessel,
    ratio: Annotated[
        float, typer.Argument(metavar="RATIO", help="New length over old; 30 makes 1:1 of 1:30.", min=0.0)
    ],
    name: Annotated[str, typer.Option(metavar="NAME", help="Of the new vessel; <vessel>_<ratio> if left out.")] = "",
    description: Annotated[
        str, typer.Option(metavar="TEXT", help="Of the new vessel; that of VESSEL and the ratio if left out.")
    ] = "",
    output: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where the file goes; to standard output if left out.")
    ] = None,
) -> None:
    """Write a vessel at another length by Froude's law: every number by its unit, the density of water as it is.

    The time step is rounded to whole nanoseconds, as time stamps are. Data files and what the vessel extends are
    written out.
    """
    new = scaled(load_vessel(vessel), ratio, name, description)
    text = section_text(new, _remarks(vessel, ratio, name, description))
    if output is None:
        print(text, end="")
        return
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise FolderError(f"{output}: cannot be written: {error.strerror}") from error
    console.print(f"vessel  {output}", soft_wrap=True)


def _remarks(vessel: str, ratio: float, name: str, description: str) -> str:
    command = ["dp", "vessel", "scale", vessel, f"{ratio:g}"]
    command += ["--name", name] if name else []
    command += ["--description", description] if description else []
    return f"""\
Made by: {shlex.join(command)}
Every number is that of the vessel it was made of, scaled by its unit with gravity and the density of water kept.
Sources and reasons are in that vessel's file: change it there, and make this one again."""
