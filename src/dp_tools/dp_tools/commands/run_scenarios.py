"""`dp scenario run`: sail scenarios, over seeds, and judge them."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from dp_tools.campaign.index import INDEX_DATA_NAME, find_entries
from dp_tools.campaign.machine import cores, machine
from dp_tools.campaign.order import Order, Outcome
from dp_tools.campaign.plan import RunPlan, plan
from dp_tools.campaign.summary import SUMMARY_NAME, RunSummary
from dp_tools.campaign.workers import RunFailedError, fill_all
from dp_tools.commands.root import INTERRUPTED, console, error_console
from dp_tools.run_folder import RunFolder
from marine_model import load_vessel
from marine_model.errors import DpError

_ONE_SEED_FOLDER = ".seed"


def run(
    names: Annotated[
        list[str],
        typer.Argument(metavar="NAME...", help="Scenarios by name or file; a for run_a; all for the thesis's runs."),
    ],
    in_process: Annotated[
        bool, typer.Option("--inprocess", metavar="", help="Without middleware, several runs at once.")
    ] = False,
    separate: Annotated[
        bool, typer.Option("--separate", metavar="", help="On the graph: a process a node instead of one for all.")
    ] = False,
    compare: Annotated[
        bool, typer.Option("--compare", metavar="", help="On the graph: sail in process as well and compare.")
    ] = False,
    repeat: Annotated[int, typer.Option(metavar="N", help="Seeds: the scenario's own, and those after it.", min=1)] = 1,
    seeds: Annotated[str, typer.Option(metavar="1,2,...", help="Seeds, instead of --repeat.")] = "",
    jobs: Annotated[int, typer.Option(metavar="N", help="Processes in process; 0: as many as cores.", min=0)] = 0,
    output: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder with one folder a scenario.")] = Path("runs"),
    overwrite: Annotated[
        bool, typer.Option("--overwrite", metavar="", help="Replace recordings that are there.")
    ] = False,
    vessel: Annotated[str, typer.Option(metavar="NAME|FILE", help="Vessel instead of the scenarios' own.")] = "",
    no_bag: Annotated[bool, typer.Option("--no-bag", metavar="", help="In process: write no recording.")] = False,
) -> None:
    """Sail scenarios and judge every figure; one table of all runs in the end.

    The lockstep graph sails them one after the other; --inprocess sails several at once. The first seed of a scenario
    leaves its recording and report in FOLDER/<scenario>, the others their figures only. Exit code 0 if every run came
    to its end, whatever the verdicts; 1 if one did not (the others go on); 130 if Ctrl-C or SIGTERM cut them short.
    """
    if in_process and (separate or compare):
        raise typer.BadParameter("--separate and --compare are about the graph, not --inprocess")
    if no_bag and not in_process:
        raise typer.BadParameter("--no-bag needs --inprocess")
    chosen = load_vessel(vessel) if vessel else None
    plans = plan(names, chosen, _seeds(seeds), repeat, output.absolute(), overwrite)
    for one in plans:
        (one.folder / SUMMARY_NAME).unlink(missing_ok=True)
    started = time.monotonic()
    campaign = Campaign(plans, vessel, jobs or cores())
    try:
        if in_process:
            campaign.sail_in_process(not no_bag)
        else:
            campaign.sail_on_graph(not separate, compare)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # nothing is left to interrupt but the exit code
        error_console.print("interrupted; every process is stopped")
        raise typer.Exit(INTERRUPTED) from None
    _tell(campaign, output, time.monotonic() - started)
    if any(campaign.failures.values()):
        raise typer.Exit(1)


def _seeds(text: str) -> tuple[int, ...]:
    try:
        found = tuple(int(part) for part in text.split(",")) if text else ()
    except ValueError:
        raise typer.BadParameter(f"--seeds: expected whole numbers such as 1,2,3, found {text}") from None
    if any(seed < 0 for seed in found):
        raise typer.BadParameter(f"--seeds: expected numbers from 0, found {text}")
    return found


def _tell(campaign: Campaign, output: Path, wall: float) -> None:
    from dp_tools.campaign.page import write_index
    from dp_tools.campaign.terminal import print_tables

    folder = output.absolute()
    entries = find_entries([folder], folder)
    page = write_index(folder, entries)
    sailed = {one.scenario.name for one in campaign.plans}
    shown = [entry for entry in entries if entry.summary.name in sailed]
    print_tables(shown)
    for name, failures in campaign.failures.items():
        for seed, why in failures:
            error_console.print(f"{name}, seed {seed}: {why}", markup=False, highlight=False, soft_wrap=True)
    runs = sum(len(one.seeds) for one in campaign.plans)
    console.print(f"sailed  {runs} runs in {wall:.1f} s, start and reports included")
    console.print(f"index   {page}", soft_wrap=True)
    console.print(f"data    {folder / INDEX_DATA_NAME}", soft_wrap=True)


@dataclass
class Campaign:
    """Runs that are being sailed.

    Parameters
    ----------
    plans
        What to sail.
    vessel
        Instead of the scenarios' own; empty for those.
    jobs
        Processes at once.
    """

    plans: Sequence[RunPlan]
    vessel: str
    jobs: int
    failures: dict[str, list[tuple[int, str]]] = field(default_factory=dict)

    def sail_in_process(self, bag: bool) -> None:
        """Sail all runs in process. Raises KeyboardInterrupt."""
        orders = []
        for one in self.plans:
            for seed in one.seeds:
                first = seed == one.seeds[0]
                folder = one.folder if first else None
                orders.append((one, Order(str(one.file), self.vessel, seed, folder, bag and first)))
        # The longest first: no processor waits for a long one in the end.
        orders.sort(key=lambda item: (item[1].folder is None, -item[0].scenario.duration))
        self._fill(orders)

    def sail_on_graph(self, composed: bool, compare: bool) -> None:
        """Sail all runs on the lockstep graph, one after the other; then judge them. Raises KeyboardInterrupt."""
        orders = []
        try:
            with Bars(self.plans) as bars:
                for one in self.plans:
                    for seed in one.seeds:
                        first = seed == one.seeds[0]
                        folder = RunFolder(one.folder if first else one.folder / f"{_ONE_SEED_FOLDER}_{seed}")
                        try:
                            self._sail_on_graph(one, seed, folder, composed, bars)
                        except DpError as error:
                            self.failures.setdefault(one.scenario.name, []).append((seed, str(error)))
                            continue
                        keep = one.folder if first else None
                        order = Order(str(one.file), self.vessel, seed, keep, recorded=folder.bag, compare=compare)
                        orders.append((one, order))
            self._fill(orders)
        finally:
            for one in self.plans:
                for seed in one.seeds:
                    shutil.rmtree(one.folder / f"{_ONE_SEED_FOLDER}_{seed}", ignore_errors=True)

    def _sail_on_graph(self, one: RunPlan, seed: int, folder: RunFolder, composed: bool, bars: Bars) -> None:
        # ROS is loaded for the graph only.
        from dp_tools.graph_run import GraphRun
        from dp_tools.run_files import Pace

        folder.prepare(overwrite=True)
        scenario = one.scenario.model_copy(update={"seed": seed})
        if seed != one.scenario.seed:
            scenario._path = None  # its file has another seed
        run = GraphRun(
            folder,
            self.vessel or scenario.vessel,
            scenario,
            Pace(lockstep=True, rate=0.0),
            record=True,
            composed=composed,
            overwrite=True,
        )
        bars.begin(one, seed)
        run.sail(lambda text: None, lambda simulated: bars.at(one, seed, simulated))
        bars.end(one, seed)

    def _fill(self, orders: Sequence[tuple[RunPlan, Order]]) -> None:
        """Fill orders, and write the summary of every scenario as soon as its last seed is there."""
        outcomes: dict[str, dict[int, Outcome]] = {one.scenario.name: {} for one in self.plans}
        open_seeds = {one.scenario.name: 0 for one in self.plans}
        for one, _ in orders:
            open_seeds[one.scenario.name] += 1

        with Bars(self.plans) as bars:

            def progress(number: int, simulated: float) -> None:
                one, order = orders[number]
                bars.at(one, order.seed, simulated)

            def done(number: int, result: Outcome | RunFailedError) -> None:
                one, order = orders[number]
                name = one.scenario.name
                if isinstance(result, RunFailedError):
                    self.failures.setdefault(name, []).append((order.seed, str(result)))
                else:
                    outcomes[name][order.seed] = result
                bars.end(one, order.seed)
                open_seeds[name] -= 1
                if not open_seeds[name]:
                    self._summarise(one, outcomes[name])

            fill_all([order for _, order in orders], self.jobs, progress, done)
        for one in self.plans:
            if not (one.folder / SUMMARY_NAME).exists():
                self._summarise(one, outcomes[one.scenario.name])

    def _summarise(self, one: RunPlan, outcomes: dict[int, Outcome]) -> None:
        found = [outcomes[seed] for seed in one.seeds if seed in outcomes]
        failures = sorted(self.failures.get(one.scenario.name, []))
        RunSummary.of(one.scenario, machine(), found, failures).write(one.folder)


class Bars:
    """One bar a scenario over all its seeds, and one over everything."""

    def __init__(self, plans: Sequence[RunPlan]) -> None:
        self._progress = Progress(
            TextColumn("{task.description:<12}"),
            BarColumn(),
            TextColumn("{task.completed:6.0f} of {task.total:.0f} s, {task.fields[speed]:.3g} x real time"),
            TimeElapsedColumn(),
            console=console,
        )
        self._tasks: dict[str, TaskID] = {}
        self._reached: dict[tuple[str, int], float] = {}
        self._durations = {one.scenario.name: one.scenario.duration for one in plans}
        for one in plans:
            total = one.scenario.duration * len(one.seeds)
            self._tasks[one.scenario.name] = self._progress.add_task(
                one.scenario.name, total=total, speed=0.0, start=False
            )
        everything = sum(one.scenario.duration * len(one.seeds) for one in plans)
        self._all = self._progress.add_task("all", total=everything, speed=0.0)
        self._begun: dict[str, float] = {}
        self._first = time.monotonic()

    def __enter__(self) -> Bars:
        self._progress.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._progress.stop()

    def begin(self, one: RunPlan, seed: int) -> None:
        """Note that a run has begun."""
        name = one.scenario.name
        if name not in self._begun:
            self._begun[name] = time.monotonic()
            self._progress.start_task(self._tasks[name])

    def at(self, one: RunPlan, seed: int, simulated: float) -> None:
        """Show that a run has come to ``simulated`` (s)."""
        self.begin(one, seed)
        name, now = one.scenario.name, time.monotonic()
        self._reached[name, seed] = simulated
        own = sum(reached for (of, _), reached in self._reached.items() if of == name)
        everything = sum(self._reached.values())
        self._progress.update(self._tasks[name], completed=own, speed=own / max(now - self._begun[name], 1e-3))
        self._progress.update(self._all, completed=everything, speed=everything / max(now - self._first, 1e-3))

    def end(self, one: RunPlan, seed: int) -> None:
        """Show that a run is over."""
        self.at(one, seed, self._durations[one.scenario.name])
        reached = [self._reached.get((one.scenario.name, each), 0.0) for each in one.seeds]
        if all(value >= one.scenario.duration for value in reached):
            self._progress.stop_task(self._tasks[one.scenario.name])
