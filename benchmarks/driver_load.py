"""Processor time of the drivers' node in real time: 50 control steps a second for CyberShip III."""

from __future__ import annotations

import shutil
import time
from collections.abc import Sequence

import psutil

from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from dp_bringup.processes import Child
from dp_tools.graph_run import GraphRun
from dp_tools.run_files import Pace
from dp_tools.run_folder import RunFolder
from marine_model import load_vessel
from marine_model.errors import DpError

_NODE = "thruster_drivers"
_TENTH = Aim("value", "<=", 0.1)


def measure_driver_load(plan: Plan) -> list[Result]:
    """Measure the share of one core that the node needs, its start left out.

    Raises
    ------
    DpError
        If the run fails, or ends before two looks at the node.
    """
    vessel = load_vessel(plan.vessel)
    folder = RunFolder(plan.scratch / "driver_load")
    folder.prepare(overwrite=True)
    events = tuple(event for event in plan.scenario.events if event.at == 0.0)
    scenario = plan.scenario.model_copy(update={"duration": plan.load_seconds, "events": events})
    looks: list[tuple[float, float]] = []  # wall and processor time, s

    def look(simulated: float) -> None:
        for process in psutil.Process().children(recursive=True):
            if any(_NODE in part for part in process.cmdline()):
                spent = process.cpu_times()
                looks.append((time.perf_counter(), spent.user + spent.system))
                return

    def arrived(running: Sequence[Child]) -> None:
        look(scenario.duration)

    run = GraphRun(folder, plan.vessel, scenario, Pace(False, 1.0), record=False, composed=False)
    run.sail(lambda text: None, lambda simulated: look(simulated) if len(looks) < 1 else None, arrived)
    shutil.rmtree(folder.path, ignore_errors=True)
    if len(looks) < 2:
        raise DpError(f"driver_load: expected two looks at {_NODE}, found {len(looks)}")
    (began, busy_before), (ended, busy_after) = looks[0], looks[-1]
    share = (busy_after - busy_before) / (ended - began)
    rate = 1.0 / vessel.simulation.time_step
    return [
        Result(
            "driver_node_load",
            share,
            "of one core",
            aim=_TENTH,
            note=f"{rate:.0f} control steps a second for {len(vessel.thrusters)} thrusters in real time, over "
            f"{ended - began:.0f} s; {share / rate * 1e6:.0f} us of processor time a step, messages included",
        )
    ]
