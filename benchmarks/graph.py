"""Run A on the graph in lockstep: real-time factor, and memory when it has arrived."""

from __future__ import annotations

import shutil
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

import psutil

from benchmarks.plan import Plan
from benchmarks.result import REAL_TIME, Aim, Result
from benchmarks.statistics import summarize
from dp_bringup.processes import Child
from dp_tools.graph_run import GraphRun
from dp_tools.run_files import Pace
from dp_tools.run_folder import RunFolder

_MEGABYTE = 1e6


@dataclass(frozen=True, slots=True)
class Memory:
    """Memory of one process, in bytes."""

    proportional: int  # pages of its own, and its share of those it shares (PSS)
    unique: int  # pages of its own (USS)
    resident: int  # all it has in memory, shared pages in full (RSS)


@dataclass(frozen=True, slots=True)
class Voyage:
    """What one run shows."""

    factor: float  # simulated over wall time, from the first advance to the end of the last
    memory: dict[str, Memory]  # by process
    processor: dict[str, float]  # s of processor time, by process, start included


def sail(plan: Plan, composed: bool, record: bool) -> Voyage:
    """Play the scenario of ``plan`` in lockstep, without a limit of rate.

    Raises
    ------
    DpError
        If the run fails.
    """
    path = plan.scratch / f"{'composed' if composed else 'separate'}{'_recorded' if record else ''}"
    shutil.rmtree(path, ignore_errors=True)
    folder = RunFolder(path)
    folder.prepare(overwrite=True)
    run = GraphRun(folder, plan.vessel, plan.scenario, Pace(True, 0.0), record, composed)
    begin: list[float] = []
    end: list[float] = []
    memory: dict[str, Memory] = {}
    processor: dict[str, float] = {}

    def progress(simulated: float) -> None:
        if not begin:
            begin.append(time.perf_counter())

    def arrived(running: Sequence[Child]) -> None:
        end.append(time.perf_counter())
        for child in running:
            process = psutil.Process(child.pid)
            seen = process.memory_full_info()
            memory[child.name] = Memory(seen.pss, seen.uss, seen.rss)
            spent = process.cpu_times()
            processor[child.name] = spent.user + spent.system

    run.sail(lambda text: None, progress, arrived)
    shutil.rmtree(path, ignore_errors=True)
    return Voyage(plan.scenario.duration / (end[0] - begin[0]), memory, processor)


def measure_separate(plan: Plan) -> list[Result]:
    """Measure one process a node: real-time factor without and with the recorder in turn, and memory."""
    bare, recorded = _voyages(plan, composed=False)
    return [
        _factor("real_time_factor_separate", bare, Aim("value", ">=", 8.0)),
        _factor("real_time_factor_separate_recording", recorded, None),
        *_memory(bare[-1].memory, recorded[-1].memory),
    ]


def measure_composed(plan: Plan) -> list[Result]:
    """Measure all nodes in one process: real-time factor without and with the recorder in turn."""
    bare, recorded = _voyages(plan, composed=True)
    return [
        _factor("real_time_factor_composed", bare, Aim("value", ">=", 25.0)),
        _factor("real_time_factor_composed_recording", recorded, None),
        Result(
            "memory_composed_pss",
            bare[-1].memory["composed"].proportional / _MEGABYTE,
            "MB",
            note=f"RSS {bare[-1].memory['composed'].resident / _MEGABYTE:.0f} MB; no recorder",
        ),
    ]


def _voyages(plan: Plan, composed: bool) -> tuple[list[Voyage], list[Voyage]]:
    bare, recorded = [], []
    for _ in range(plan.graph_runs):
        bare.append(sail(plan, composed, record=False))
        recorded.append(sail(plan, composed, record=True))
    return bare, recorded


def _factor(name: str, voyages: Sequence[Voyage], aim: Aim | None) -> Result:
    summary = summarize([voyage.factor for voyage in voyages])
    busy = {
        process: statistics.median(voyage.processor[process] for voyage in voyages) for process in voyages[0].processor
    }
    spent = ", ".join(f"{process} {seconds:.1f}" for process, seconds in busy.items())
    return Result(
        name,
        summary.median,
        REAL_TIME,
        aim=aim,
        note=f"median of {summary.count}, {summary.low:.1f} to {summary.high:.1f}; processor s: {spent}",
    )


def _memory(nodes: dict[str, Memory], with_recorder: dict[str, Memory]) -> list[Result]:
    proportional = sum(memory.proportional for memory in nodes.values())
    resident = sum(memory.resident for memory in nodes.values())
    everything = {**nodes, **{name: memory for name, memory in with_recorder.items() if name not in nodes}}
    return [
        Result(
            "memory_graph_pss",
            proportional / _MEGABYTE,
            "MB",
            aim=Aim("value", "<=", 600.0),
            note=f"sum of PSS of {len(nodes)} nodes at the end; sum of RSS {resident / _MEGABYTE:.0f} MB",
        ),
        Result("memory_graph_rss", resident / _MEGABYTE, "MB", note="counts shared pages once a process"),
        *(
            Result(
                f"memory_{name}_pss",
                memory.proportional / _MEGABYTE,
                "MB",
                note=f"USS {memory.unique / _MEGABYTE:.0f} MB, RSS {memory.resident / _MEGABYTE:.0f} MB",
            )
            for name, memory in everything.items()
        ),
    ]
