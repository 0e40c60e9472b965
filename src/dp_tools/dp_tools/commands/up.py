"""`dp up`: start the graph."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from dp_tools.commands.report import write_and_tell
from dp_tools.commands.root import console
from dp_tools.graph_run import GraphRun
from dp_tools.run_files import Pace, RunFolder
from dp_tools.scenario import Scenario, load_scenario
from marine_model import load_vessel


def up(
    scenario: Annotated[
        str, typer.Option(help="Scenario to play: a name (dp scenario list) or a file. Without one, run until Ctrl-C.")
    ] = "",
    vessel: Annotated[str, typer.Option(help="Vessel: a name or a file. Overrides the scenario's.")] = "",
    record: Annotated[bool, typer.Option("--record", help="Record every topic to an MCAP bag.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Write the report in the end; needs --record.")] = False,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="The simulator waits for the ring: repeatable to the bit.")
    ] = False,
    rate: Annotated[
        float | None,
        typer.Option(
            help="Simulated seconds a wall second; 0: no limit, with --lockstep only. Default 1, 0 with --lockstep.",
            min=0.0,
        ),
    ] = None,
    composed: Annotated[bool, typer.Option("--composed", help="All nodes in one process.")] = False,
    namespace: Annotated[str, typer.Option(help="Namespace of the whole graph.")] = "",
    output: Annotated[Path | None, typer.Option(help="Folder of the run; runs/<scenario> if left out.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a recording that is there.")] = False,
) -> None:
    """Start the graph, play a scenario if one is given, and stop everything in the end."""
    chosen = load_scenario(scenario) if scenario else None
    if report and (chosen is None or not record):
        raise typer.BadParameter("--report needs --scenario and --record")
    if rate is None:
        rate = 0.0 if lockstep else 1.0
    if rate == 0.0 and not lockstep:
        raise typer.BadParameter("--rate 0 (no limit) needs --lockstep")
    vessel_name = vessel or (chosen.vessel if chosen else "cybership3")
    load_vessel(vessel_name)
    folder = RunFolder((output or Path("runs") / (chosen.name if chosen else "up")).absolute())
    folder.prepare(overwrite or not record)
    run = GraphRun(folder, vessel_name, chosen, Pace(lockstep, rate), record, composed, namespace, overwrite)
    started = time.monotonic()
    if chosen is None:
        try:
            run.sail(console.print, lambda simulated: None)
        except KeyboardInterrupt:
            console.print("stopped")
    else:
        _sail_with_bar(run, chosen)
        wall = time.monotonic() - started
        console.print(f"sailed {chosen.duration:g} s in {wall:.1f} s, start and stop included")
    if record:
        console.print(f"bag     {folder.bag}", soft_wrap=True)
    if report and chosen is not None:
        write_and_tell(folder.bag, folder.path)


def _sail_with_bar(run: GraphRun, scenario: Scenario) -> None:
    columns = (
        TextColumn("{task.description:16}"),
        BarColumn(),
        TextColumn("{task.completed:5.0f} of {task.total:.0f} s, {task.fields[speed]:.0f} x"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("starting", total=scenario.duration, speed=0.0)
        begun: list[float] = []

        def say(text: str) -> None:
            bar.update(task, description=f"{scenario.name}: {text}"[:28])

        def progress(simulated: float) -> None:
            now = time.monotonic()
            if not begun:
                begun.append(now)
            speed = simulated / max(now - begun[0], 1e-3)
            bar.update(task, completed=simulated, speed=speed)

        run.sail(say, progress)
        bar.update(task, completed=scenario.duration)
