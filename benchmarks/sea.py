"""Run A in an irregular sea: real-time factor beside MCSimPython in the same wave components."""

from __future__ import annotations

import time

from benchmarks.in_process import sail
from benchmarks.mcsimpython_peer import PEER, PeerMissingError, VesselInWaves
from benchmarks.plan import Plan
from benchmarks.result import REAL_TIME as UNIT
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from dp_tools.node_settings import SIMULATOR
from dp_tools.scenario import Scenario
from marine_model import load_vessel


def in_a_sea(scenario: Scenario, components: int) -> Scenario:
    """Return the scenario with its regular waves replaced by a short-crested sea.

    The significant height is the amplitude that the regular waves have, as twice of it would be steeper than seas get;
    the peak period is their period. s = 10 in the spreading function is that of wind sea.
    """
    waves = scenario.parameters[SIMULATOR]
    sea = {
        "waves.kind": "jonswap",
        "waves.significant_height": waves["waves.amplitude"],
        "waves.peak_period": waves["waves.period"],
        "waves.components": components,
        "waves.spreading": 10.0,
    }
    return scenario.model_copy(update={"parameters": {**scenario.parameters, SIMULATOR: {**waves, **sea}}})


def measure_sea(plan: Plan) -> list[Result]:
    """Sail the scenario in a sea in process, in turn with the peer's hull in the same components.

    The peer sails for ``plan.sea_seconds`` only: its effort grows with the square of their number.
    """
    vessel, scenario = load_vessel(plan.vessel), in_a_sea(plan.scenario, plan.sea_components)
    ours, busy, theirs = [], [], []
    missing = ""
    for _ in range(plan.sea_runs):
        wall, processor = sail(scenario, vessel)
        ours.append(scenario.duration / wall)
        busy.append(scenario.duration / processor)
        if missing:
            continue
        try:
            peer = VesselInWaves(vessel, scenario.settings(vessel))
        except PeerMissingError as error:
            missing = str(error)
            continue
        begin = time.perf_counter()
        peer.sail(plan.sea_seconds)
        theirs.append(plan.sea_seconds / (time.perf_counter() - begin))
    summary = summarize(ours)
    return [
        Result(
            "real_time_factor_in_process_sea",
            summary.median,
            UNIT,
            f"not measured: {missing}" if missing else f"{PEER} (hull and waves)",
            summarize(theirs).median if theirs else None,
            Aim("value", ">=", 200.0),
            f"{plan.sea_components} components; median of {summary.count} runs, {summary.low:.0f} to "
            f"{summary.high:.0f}; by processor time {summarize(busy).median:.0f}; the peer for {plan.sea_seconds:g} s",
        )
    ]
