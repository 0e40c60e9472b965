"""Fills one order."""

from __future__ import annotations

from collections.abc import Callable

from dp_tools.bag_reader import read_bag
from dp_tools.campaign.order import Order, Outcome
from dp_tools.in_process import ClosedLoop
from dp_tools.run_bag import write_bag
from dp_tools.run_data import RunData
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Scenario
from marine_model import Vessel


def fill(order: Order, progress: Callable[[float], None]) -> Outcome:
    """Sail a run, or judge one that the graph has sailed; write its bag and report.

    Parameters
    ----------
    order
        What to do.
    progress
        Told the simulated time (s) now and then.

    Raises
    ------
    DpError
        If the scenario is not valid, a core refuses an event, a bag cannot be read, or a figure cannot be worked out.
    OSError
        If the folder cannot be written.
    """
    if order.recorded is not None:
        recorded = read_bag(order.recorded, order.vessel)
        vessel, scenario = order.load()
        other = ClosedLoop(vessel, scenario).run(progress) if order.compare else None
        outcome = Outcome.of(recorded.run, scenario, vessel, other)
        run = recorded.run
    else:
        vessel, scenario = order.load()
        run = ClosedLoop(vessel, scenario).run(progress)
        outcome = Outcome.of(run, scenario, vessel)
        if order.bag and order.folder is not None:
            # The folder was asked about before anything was sailed.
            write_bag(RunFolder(order.folder).bag, run, vessel, scenario, overwrite=True)
    if order.folder is not None:
        _report(order, run, scenario, vessel)
    return outcome


def _report(order: Order, run: RunData, scenario: Scenario, vessel: Vessel) -> None:
    if order.folder is not None:
        # Plotting libraries load slowly; only a run with a report waits for them.
        from dp_tools.report import write_report

        write_report(run, scenario, vessel, order.folder)
