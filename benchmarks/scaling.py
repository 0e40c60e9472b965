"""How the cost of a step grows with the number of thrusters and of sectors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from benchmarks.allocation import ours
from benchmarks.blocks import Candidate, in_turn
from benchmarks.demands import DemandSequence, Step, record, saturated_share, sequence, starter
from benchmarks.fleet import with_thrusters, with_windows
from benchmarks.peers.osqp_peer import OsqpThroughQpsolvers
from benchmarks.peers.peer import PeerMissingError
from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from benchmarks.sub_problems import OURS, record_sectors, start, window_counts
from marine_model import Vessel, load_vessel
from thrust_allocator import AllocatorSettings

_SEED = 23
_TIMES_AS_MANY = (1, 2, 4, 8)  # thrusters: 4, 8, 16, 32 for CyberShip III
_WINDOWS = (1, 2, 3, 4)  # of each azimuth thruster
# Near linear: the exponent of a straight line through the origin is 1, that of one that starts higher is less.
_NEAR_LINEAR = Aim("value", "<=", 1.1)


def measure_scaling(plan: Plan) -> list[Result]:
    """Measure steps for vessels with more thrusters, and with more sectors."""
    vessel = load_vessel(plan.vessel)
    total = 2 * len(_TIMES_AS_MANY) + len(_WINDOWS)
    results: list[Result] = []
    done = 0
    for mode in ("fixed", "rotating"):
        counts, medians = [], []
        for times in _TIMES_AS_MANY:
            larger = with_thrusters(vessel, times * len(vessel.thrusters))
            counts.append(len(larger.thrusters))
            row = _thrusters(plan, larger, AllocatorSettings(azimuth_mode=mode))
            medians.append(row.value)
            results.append(row)
            done += 1
            plan.progress(done, total)
        results.append(
            Result(
                f"scaling_{mode}_exponent",
                exponent(counts, medians),
                "",
                aim=_NEAR_LINEAR,
                note=f"time ~ thrusters^exponent over {', '.join(map(str, counts))} thrusters, by least squares",
            )
        )
    combinations, medians = [], []
    # The same demands for all: those that saturate a third of the steps without sectors.
    steps = max(2, plan.sector_blocks * plan.sector_steps // 4)
    demands = sequence(vessel, starter(vessel, AllocatorSettings(azimuth_mode="rotating")), steps, _SEED)
    for windows in _WINDOWS:
        row, number = _sectors(vessel, demands, windows)
        combinations.append(number)
        medians.append(row.value)
        results.append(row)
        done += 1
        plan.progress(done, total)
    results.append(
        Result(
            "scaling_sectors_exponent",
            exponent(combinations, medians),
            "",
            note=f"time ~ combinations^exponent over {', '.join(map(str, combinations))} combinations; {OURS}",
        )
    )
    return results


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Return p of times ~ sizes^p, by least squares of the logarithms."""
    slope, _ = np.polyfit(np.log(sizes), np.log(times), 1)
    return float(slope)


def _thrusters(plan: Plan, vessel: Vessel, settings: AllocatorSettings) -> Result:
    """Return the median step beside OSQP's."""
    count = plan.sector_blocks * plan.sector_steps
    demands = sequence(vessel, starter(vessel, settings), count, _SEED)
    steps = record(vessel, settings, demands.demands, demands.dt)
    candidates = {"ours": ours(vessel, settings, steps)}
    missing, title = "", ""
    try:
        peer = OsqpThroughQpsolvers()
        candidates["osqp"] = Candidate(peer.prepare, peer.solve, share=0.1)
        title = peer.title
    except PeerMissingError as error:
        missing = f"not measured: {error}"
    calls = in_turn(candidates, steps, plan.sector_blocks)
    mine = summarize(calls["ours"].times)
    return Result(
        f"scaling_{settings.azimuth_mode}_{len(vessel.thrusters)}_thrusters",
        mine.median,
        "us",
        missing or title,
        None if missing else summarize(calls["osqp"].times).median,
        note=f"{mine.count} steps, {demands.saturated:.0%} saturated, p99 {mine.p99:.0f} us",
    )


def _sectors(vessel: Vessel, demands: DemandSequence, count: int) -> tuple[Result, int]:
    """Return the median step with ``count`` windows a thruster, and the number of combinations."""
    vessel = with_windows(vessel, count)
    number = math.prod(window_counts(vessel))
    steps = [one.step for one in record_sectors(vessel, demands.demands, demands.dt)]
    allocator = [start(vessel)]

    def prepare(step: Step) -> Step:
        if step is steps[0]:
            allocator[0] = start(vessel)
        return step

    candidate = Candidate(prepare, lambda step: allocator[0].step(step.tau, step.dt))
    mine = summarize(in_turn({"ours": candidate}, steps, 2)["ours"].times)
    return (
        Result(
            f"scaling_sectors_{number}_combinations",
            mine.median,
            "us",
            note=(
                f"{count} windows a thruster; {mine.count} steps, {saturated_share(vessel, steps):.0%} saturated, "
                f"p99 {mine.p99:.0f} us"
            ),
        ),
        number,
    )
