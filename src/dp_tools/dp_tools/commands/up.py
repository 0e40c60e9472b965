"""`dp up`: start the graph."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from dp_bringup.processes import Child, ChildDiedError
from dp_bringup.supervisor import CannotStartError, Rules
from dp_tools.commands.record import DEFAULT, Compression
from dp_tools.commands.report import write_and_tell
from dp_tools.commands.root import INTERRUPTED, Namespace, console, error_console
from dp_tools.graph_run import GraphRun, Supervision, UncleanStopError
from dp_tools.run_files import Pace
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Scenario, load_scenario
from marine_model import load_vessel


def up(
    scenario: Annotated[
        str,
        typer.Option(metavar="NAME|FILE", help="Scenario to play (dp scenario list). Without one, run until Ctrl-C."),
    ] = "",
    vessel: Annotated[str, typer.Option(metavar="NAME|FILE", help="Vessel instead of the scenario's.")] = "",
    record: Annotated[bool, typer.Option("--record", metavar="", help="Record every topic to an MCAP bag.")] = False,
    compression: Compression = DEFAULT,
    report: Annotated[
        bool, typer.Option("--report", metavar="", help="Write the report in the end; needs --scenario and --record.")
    ] = False,
    lockstep: Annotated[
        bool,
        typer.Option("--lockstep", metavar="", help="The simulator waits for the ring: repeatable to the bit."),
    ] = False,
    rate: Annotated[
        float | None,
        typer.Option(
            metavar="NUMBER",
            help="Simulated seconds a wall second. 1 if left out; with --lockstep 0, which is no limit.",
            min=0.0,
        ),
    ] = None,
    no_restart: Annotated[
        bool,
        typer.Option("--no-restart", metavar="", help="Stop with the reason if a node dies; --lockstep always does."),
    ] = False,
    hang_timeout: Annotated[
        float,
        typer.Option(metavar="SECONDS", help="A node that is silent for so long is killed and restarted.", min=0.1),
    ] = Rules.hang_timeout,
    composed: Annotated[bool, typer.Option("--composed", metavar="", help="All nodes in one process.")] = False,
    namespace: Namespace = "",
    output: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder of the run; runs/<scenario> if left out.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", metavar="", help="Replace a recording that is there.")
    ] = False,
) -> None:
    """Start the graph, play a scenario if one is given, and stop everything in the end.

    Exit code 0 if the scenario was played to its end, or the graph ran without one until Ctrl-C; 1 if something went
    wrong, e.g. a node could not start; 130 if Ctrl-C or SIGTERM cut the scenario short.
    """
    if report and not (scenario and record):
        raise typer.BadParameter("--report needs --scenario and --record")
    if rate is None:
        rate = 0.0 if lockstep else 1.0
    if rate == 0.0 and not lockstep:
        raise typer.BadParameter("--rate 0 (no limit) needs --lockstep")
    chosen = load_scenario(scenario, load_vessel(vessel) if vessel else None) if scenario else None
    vessel_name = vessel or (chosen.vessel if chosen else "cybership3")
    load_vessel(vessel_name)
    folder = RunFolder((output or Path("runs") / (chosen.name if chosen else "up")).absolute())
    folder.prepare(overwrite or not record)
    run = GraphRun(folder, vessel_name, chosen, Pace(lockstep, rate), record, composed, namespace, overwrite)
    supervision = None if no_restart or lockstep else Supervision(_teller(folder.logs), _rules(hang_timeout))
    run = replace(run, compression=compression.value, supervision=supervision)
    interrupted = False
    try:
        if chosen is None:
            run.sail(console.print, lambda simulated: None, warn=_warn)
        else:
            _sail_with_bar(run, chosen)
    except KeyboardInterrupt:
        interrupted = True
    except (ChildDiedError, CannotStartError, UncleanStopError):
        _tell_bag(run)
        raise
    _tell_bag(run)
    if interrupted and chosen is not None:  # without a scenario it is the way to stop
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # nothing is left to interrupt but the exit code
        error_console.print("interrupted; every process is stopped")
        raise typer.Exit(INTERRUPTED)
    if report:
        write_and_tell(folder.bag, folder.path)


def _rules(hang_timeout: float) -> Rules:
    return Rules(hang_timeout=hang_timeout, silent_after=min(Rules.silent_after, hang_timeout))


def _teller(logs: Path) -> Callable[[str], None]:
    """Return what tells of restarts in the terminal, and with the time in a log beside those of the nodes."""

    def tell(text: str) -> None:
        console.print(f"supervisor: {text}", markup=False, highlight=False, soft_wrap=True)
        with (logs / "supervisor.log").open("a", encoding="utf-8") as log:
            log.write(f"{datetime.now(UTC).isoformat(timespec='milliseconds')} {text}\n")

    return tell


def _warn(text: str) -> None:
    """Say at once what cannot wait until the end; on the console that the bar knows of."""
    console.print("[bold red]warning:[/]", highlight=False, end=" ")
    console.print(text, markup=False, highlight=False, soft_wrap=True)


def _tell_bag(run: GraphRun) -> None:
    if run.record and run.folder.bag.exists():
        console.print(f"bag     {run.folder.bag}", soft_wrap=True)


def _sail_with_bar(run: GraphRun, scenario: Scenario) -> None:
    started = time.monotonic()
    columns = (
        TextColumn("{task.description:<17}"),
        BarColumn(),
        TextColumn("{task.completed:5.0f} of {task.total:.0f} s, {task.fields[speed]:.3g} x"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("starting", total=scenario.duration, speed=0.0)
        begun: list[float] = []

        def say(text: str) -> None:
            bar.update(task, description=text)

        def progress(simulated: float) -> None:
            now = time.monotonic()
            if not begun:
                begun.append(now)
            speed = simulated / max(now - begun[0], 1e-3)
            bar.update(task, completed=simulated, speed=speed)

        def arrived(running: Sequence[Child]) -> None:
            progress(scenario.duration)

        run.sail(say, progress, arrived, _warn)
    wall = time.monotonic() - started
    console.print(f"sailed  {scenario.duration:g} s of {scenario.name} in {wall:.1f} s, start and stop included")
