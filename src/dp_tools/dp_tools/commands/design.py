"""`dp design`: the design loop for a vessel."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from dp_tools.commands.root import console
from dp_tools.design_files import DesignFolder
from dp_tools.design_tables import ball_lines, combination_table, split_lines, split_table
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.design import Study, study, study_rows
from thrust_allocator.design_maps import GainMap, map_cases, work_out


def design(
    vessel: Annotated[
        str, typer.Argument(metavar="VESSEL", help="Vessel, by name or file; the thesis's example if left out.")
    ] = "cybership3_ch7",
    azimuth_degrees: Annotated[
        str,
        typer.Option(
            metavar="A,B,...",
            help="Directions of the azimuth thrusters in degrees, in the order of the vessel file, for the table with "
            "fixed directions; those of the vessel file if left out.",
        ),
    ] = "",
    maps: Annotated[
        bool, typer.Option("--map", metavar="", help="Draw maps of the minimum gain over two directions.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Folder for figures, CSV and JSON; with --map design/<vessel> if left out."
        ),
    ] = None,
) -> None:
    """Judge a thruster configuration: every combination of working thrusters, and every split into two power buses.

    Rank and minimum gain as in Tables 7.1 and 7.2 of the thesis, and beside them the largest ball of generalized force
    that is attainable.
    """
    chosen = load_vessel(vessel)
    azimuth = _angles(chosen, azimuth_degrees)
    cases = map_cases(chosen) if maps else ()
    folder = DesignFolder((output or Path("design") / chosen.name).absolute()) if output or maps else None
    if folder is not None:
        folder.prepare()
    turning, fixed = _studies(chosen, azimuth)
    console.print(f"{chosen.name}: {chosen.description}", highlight=False)
    for number, name in enumerate(chosen.thruster_names, start=1):
        limits = f"{chosen.thrust_min[number - 1]:g} to {chosen.thrust_max[number - 1]:g} N"
        console.print(f"  {number} {name.replace('_', ' ')}, {limits}", highlight=False)
    console.print(combination_table(chosen, turning))
    console.print(split_table(turning))
    for line in (*split_lines(turning), *ball_lines(turning)):
        console.print(line, highlight=False, soft_wrap=True)
    console.print(combination_table(chosen, fixed))
    for line in ball_lines(fixed):
        console.print(line, highlight=False, soft_wrap=True)
    if folder is None:
        return
    # Plotting libraries load slowly; only who asked for figures waits for them.
    from dp_tools.design_plots import draw_attainable, draw_gains, draw_map, draw_overview

    drawn: list[GainMap] = []
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
    with Progress(*columns, TimeElapsedColumn(), console=console) as bar:
        task = bar.add_task("figures", total=2 + 2 * len(cases))
        draw_gains(chosen, turning, folder.path / "gains.png")
        bar.advance(task)
        draw_attainable(chosen, turning, azimuth, folder.path / "attainable.png")
        bar.advance(task)
        for number, case in enumerate(cases, start=1):
            bar.update(task, description=f"map {number} of {len(cases)}")
            drawn.append(work_out(chosen, case))
            bar.advance(task)
        for number, one in enumerate(drawn, start=1):
            draw_map(chosen, one, folder.map_file(number, one.case))
            bar.advance(task)
        if drawn:
            draw_overview(chosen, drawn, folder.path / "maps.png")
    folder.write(chosen, turning, fixed, drawn)
    console.print(f"written {folder.path}", soft_wrap=True)


def _angles(vessel: Vessel, words: str) -> FloatArray:
    """Return the directions of all thrusters, rad. Raises InputError."""
    angles = vessel.fixed_direction.copy()
    if not words:
        return angles
    turning = [j for j, can in enumerate(vessel.can_rotate) if can]
    try:
        degrees = [float(word) for word in words.split(",")]
    except ValueError:
        degrees = []
    if len(degrees) != len(turning) or not all(math.isfinite(value) for value in degrees):
        raise InputError(
            f"--azimuth-degrees: expected {len(turning)} numbers with commas between, one for each of "
            f"{', '.join(vessel.thruster_names[j] for j in turning) or 'no azimuth thruster'}, found '{words}'"
        )
    angles[turning] = [math.radians(value) for value in degrees]
    return angles


def _studies(vessel: Vessel, azimuth: FloatArray) -> tuple[Study, Study]:
    """Return the studies with freely rotating and with fixed thrusters, showing progress."""
    total = 2 * (2 ** len(vessel.thrusters) - 1)
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("combinations", total=total)
        found = []
        for angles in (None, azimuth):
            rows = []
            for row in study_rows(vessel, angles):
                rows.append(row)
                bar.advance(task)
            found.append(study(vessel, angles, rows))
    return found[0], found[1]
