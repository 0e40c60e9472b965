"""Real-time factor of the in-process loop, beside MCSimPython."""

from __future__ import annotations

import time

from benchmarks.mcsimpython_peer import PEER, PeerMissingError, StationKeeping, VesselInWaves
from benchmarks.plan import Plan
from benchmarks.result import REAL_TIME as UNIT
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import Scenario
from marine_model import Vessel, load_vessel


def measure_in_process(plan: Plan) -> list[Result]:
    """Sail the scenario in process, in turn with the peer in the same waves for the same time with the same step."""
    vessel = load_vessel(plan.vessel)
    kinds = {"vessel": VesselInWaves, "loop": StationKeeping}
    ours: list[float] = []
    busy: list[float] = []
    theirs: dict[str, list[float]] = {name: [] for name in kinds}
    missing = ""
    for _ in range(plan.loop_runs):
        wall, processor = sail(plan.scenario, vessel)
        ours.append(plan.scenario.duration / wall)
        busy.append(plan.scenario.duration / processor)
        for name, kind in kinds.items():
            if missing:
                break
            try:
                peer = kind(vessel, plan.scenario.settings(vessel))
            except PeerMissingError as error:
                missing = str(error)
                break
            begin = time.perf_counter()
            peer.sail(plan.scenario.duration)
            theirs[name].append(plan.scenario.duration / (time.perf_counter() - begin))
    summary = summarize(ours)
    note = (
        f"median of {summary.count} runs in turn with the peers', {summary.low:.0f} to {summary.high:.0f}; "
        f"by processor time {summarize(busy).median:.0f}"
    )
    aim = Aim("value", ">=", 200.0)
    if missing:
        return [
            Result("real_time_factor_in_process", summary.median, UNIT, f"not measured: {missing}", None, aim, note),
        ]
    return [
        Result(
            "real_time_factor_in_process",
            summary.median,
            UNIT,
            f"{PEER} (hull and waves)",
            summarize(theirs["vessel"]).median,
            aim,
            note,
        ),
        Result(
            "real_time_factor_in_process_against_loop",
            summary.median,
            UNIT,
            f"{PEER} (hull, waves, its control)",
            summarize(theirs["loop"]).median,
            None,
            "the same runs of ours; the peer adds observer, reference filter, PID, allocation, thruster forces",
        ),
    ]


def sail(scenario: Scenario, vessel: Vessel) -> tuple[float, float]:
    """Return wall and processor time of one run, s; making the cores is not counted."""
    loop = ClosedLoop(vessel, scenario)
    begin, busy = time.perf_counter(), time.process_time()
    loop.run()
    return time.perf_counter() - begin, time.process_time() - busy
