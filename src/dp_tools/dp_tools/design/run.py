"""The work of `dp design`: studies, tables, figures, files, in this order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from dp_tools.design.files import DesignFolder
from dp_tools.design.plots import draw_attainable, draw_gains, draw_map, draw_overview
from dp_tools.design.tables import ball_lines, bus_lines, combination_table, split_lines, split_table
from dp_tools.run_folder import FolderError
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.design.loop import Study, bus_losses, study, study_rows
from thrust_allocator.design.maps import GainMap, MapCase, map_cases, work_out


def run_design(console: Console, vessel: Vessel, degrees: str, maps: bool, output: Path | None) -> None:
    """Print the tables of a vessel, and write figures and files if there is a folder or maps are asked for.

    Parameters
    ----------
    console
        Where to print.
    vessel
        The vessel.
    degrees
        Directions of the azimuth thrusters, deg, with commas between; empty for those of the vessel file.
    maps
        Draw maps of the minimum gain.
    output
        Folder; None: design/<vessel> with ``maps``, none without.

    Raises
    ------
    InputError
        If the directions cannot be read, or there are too few azimuth thrusters for a map or too many for a table.
    FolderError
        If the folder cannot be written.
    """
    azimuth = _angles(vessel, degrees)
    cases = map_cases(vessel) if maps else ()
    folder = DesignFolder((output or Path("design") / vessel.name).absolute()) if output or maps else None
    if folder is not None:
        folder.prepare()
    turning, fixed = _studies(console, vessel, azimuth)
    console.print(f"{vessel.name}: {vessel.description}", highlight=False, markup=False)
    for number, name in enumerate(vessel.thruster_names, start=1):
        limits = f"{vessel.thrust_min[number - 1]:g} to {vessel.thrust_max[number - 1]:g} N"
        console.print(f"  {number} {name.replace('_', ' ')}, {limits}", highlight=False)
    console.print(combination_table(vessel, turning))
    console.print(split_table(turning))
    for line in (*split_lines(turning), *bus_lines(bus_losses(vessel, turning)), *ball_lines(turning)):
        console.print(line, highlight=False, soft_wrap=True)
    console.print(combination_table(vessel, fixed))
    for line in ball_lines(fixed):
        console.print(line, highlight=False, soft_wrap=True)
    if folder is None:
        return
    try:
        drawn = _draw(console, vessel, turning, azimuth, cases, folder)
    except OSError as error:
        raise FolderError(f"{folder.path}: cannot be written: {error.strerror}") from error
    folder.write(vessel, turning, fixed, drawn)
    console.print(f"written {folder.path}", soft_wrap=True)


def _draw(
    console: Console,
    vessel: Vessel,
    turning: Study,
    azimuth: FloatArray,
    cases: Sequence[MapCase],
    folder: DesignFolder,
) -> list[GainMap]:
    """Draw all figures, showing progress, and return the maps."""
    drawn: list[GainMap] = []
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
    with Progress(*columns, TimeElapsedColumn(), console=console) as bar:
        task = bar.add_task("figures", total=2 + 2 * len(cases))
        draw_gains(vessel, turning, folder.path / "gains.png")
        bar.advance(task)
        draw_attainable(vessel, turning, azimuth, folder.path / "attainable.png")
        bar.advance(task)
        for number, case in enumerate(cases, start=1):
            bar.update(task, description=f"map {number} of {len(cases)}")
            drawn.append(work_out(vessel, case))
            bar.advance(task)
        bar.update(task, description="figures of maps")
        for number, one in enumerate(drawn, start=1):
            draw_map(vessel, one, folder.map_file(number, one.case))
            bar.advance(task)
        if drawn:
            draw_overview(vessel, drawn, folder.path / "maps.png")
    return drawn


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


def _studies(console: Console, vessel: Vessel, azimuth: FloatArray) -> tuple[Study, Study]:
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
