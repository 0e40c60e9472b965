"""Start-up time: from the start of `dp up` to the first pose, which lockstep publishes once the ring is closed."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped

from benchmarks.plan import Plan
from benchmarks.result import Result
from benchmarks.statistics import summarize
from dp_bringup.operator_node import operator
from dp_bringup.processes import Children
from dp_bringup.workspace import executable
from dp_node import RING_PUBLISHER
from marine_model.errors import DpError

_SECONDS = 60.0


def measure_start_up(plan: Plan) -> list[Result]:
    """Measure it for one process a node and for one process in all."""
    results = []
    for name, options in (("start_up_separate", []), ("start_up_composed", ["--composed"])):
        summary = summarize([_start(plan, name, options) for _ in range(plan.start_ups)])
        note = f"median of {summary.count}, {summary.low:.2f} to {summary.high:.2f}"
        results.append(Result(name, summary.median, "s", note=note))
    return results


def _start(plan: Plan, name: str, options: list[str]) -> float:
    """Start the graph, wait for the first pose and stop it; return the time it took, s."""
    path = plan.scratch / name
    shutil.rmtree(path, ignore_errors=True)
    children = Children(plan.scratch / f"{name}_logs")
    arrived: list[float] = []

    def note(message: Any) -> None:
        arrived.append(time.perf_counter())

    with operator() as one:
        one.watch = children.check
        one.node.create_subscription(PoseWithCovarianceStamped, "pose", note, RING_PUBLISHER)
        begin = time.perf_counter()
        try:
            # At the pace of a clock: nobody has to keep up with it while it is stopped.
            command: list[str | Path] = [
                executable("dp_tools", "dp"),
                "up",
                "--lockstep",
                "--rate",
                "1",
                "--vessel",
                plan.vessel,
            ]
            children.start("dp_up", [*command, "--output", path, *options])
            one.wait_until(lambda: bool(arrived), _SECONDS, "the first pose")
        finally:
            problems = children.stop()
        if problems:
            raise DpError("\n".join(problems))
    return arrived[0] - begin
