"""The problem with forbidden sectors: the cheapest of 18 sub-problems, beside who solves them all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.allocation import against, p99
from benchmarks.blocks import Calls, Candidate, in_turn
from benchmarks.demands import Answer, Step, saturated_share, sequence
from benchmarks.peers.osqp_peer import OsqpThroughQpsolvers
from benchmarks.peers.peer import Commands, PeerMissingError, titled
from benchmarks.peers.quta_peer import EqualProblem, StaticSectors
from benchmarks.plan import Plan
from benchmarks.reference import optima
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from benchmarks.sub_problems import OURS, SectorStep, record_sectors, start, sub_problems, window_counts
from benchmarks.verdict import TOLERANCE, judge
from marine_model import Vessel, load_vessel
from marine_model.guards import FloatArray
from thrust_allocator.program.problem import AllocationProblem

_SEED = 21
_ROW = "sectors_18"
# Relative cost gap above which an answer counts as another one than the brute force's, and as a bad one of a peer.
_EQUAL = 1e-9
_BAD = 1e-4


def measure_sectors(plan: Plan) -> list[Result]:
    """Measure the step with sectors, and check every choice against brute force."""
    vessel = load_vessel(plan.vessel)

    def begin() -> Answer:
        allocator = start(vessel)
        return lambda tau, dt: allocator.step(tau, dt)[2]

    demands = sequence(vessel, begin, plan.sector_blocks * plan.sector_steps, _SEED)
    recorded = record_sectors(vessel, demands.demands, demands.dt)
    places = {id(one.step): i for i, one in enumerate(recorded)}
    steps = [one.step for one in recorded]

    def of(step: Step) -> SectorStep:
        return recorded[places[id(step)]]

    peers: dict[str, Any] = {}
    missing: dict[str, str] = {}
    for name, make in (
        ("osqp_qpsolvers", OsqpThroughQpsolvers),
        ("quta", lambda: EqualProblem(window_counts(vessel))),
        ("quta_static", lambda: StaticSectors(vessel)),
    ):
        try:
            peers[name] = make()
        except PeerMissingError as error:
            missing[name] = str(error)
    searcher = start(vessel)
    searcher.step(np.zeros(3), demands.dt)
    candidates = {
        "ours": _ours(vessel, steps),
        "optimum": Candidate(lambda step: step.tau, searcher.optimum),
    }
    if "osqp_qpsolvers" in peers:
        osqp = peers["osqp_qpsolvers"]
        candidates["osqp_qpsolvers"] = Candidate(
            lambda step: [osqp.program(problem) for problem in sub_problems(of(step))],
            lambda programs: [osqp.solve(program) for program in programs],
            share=0.2,
        )
    if "quta" in peers:
        quta = peers["quta"]
        candidates["quta"] = Candidate(lambda step: quta.prepare(sub_problems(of(step))), quta.solve, share=0.5)
        candidates["quta_static"] = Candidate(lambda step: step.tau, peers["quta_static"].solve, share=0.5)
    calls = in_turn(candidates, steps, plan.sector_blocks, progress=plan.progress)

    best = _brute_force(recorded)
    mine = summarize(calls["ours"].times)
    note = (
        f"{mine.count} steps, {saturated_share(vessel, steps):.0%} saturated, "
        f"{math.prod(window_counts(vessel))} sub-problems; {OURS}"
    )
    results = [
        Result(f"{_ROW}_median", mine.median, "us", note=note),
        p99(f"{_ROW}_p99", calls["ours"]),
        _equal(recorded, best),
    ]
    search = summarize(calls["optimum"].times)
    gaps = [
        abs(cost - best[place][2]) / max(best[place][2], 1e-12)
        for place, cost in zip(calls["optimum"].places, calls["optimum"].answers, strict=True)
    ]
    results += [
        Result(
            f"{_ROW}_optimum_median",
            search.median,
            "us",
            note=f"the cheapest of the sub-problems alone, what the peers find; {search.count} steps, "
            f"largest relative difference of the cost from brute force {max(gaps):.2g}",
        ),
        p99(f"{_ROW}_optimum_p99", calls["optimum"]),
    ]
    titles = {
        "osqp_qpsolvers": ("18 x " + peers["osqp_qpsolvers"].title) if "osqp_qpsolvers" in peers else "",
        "quta": f"{titled('quta')}, the same sub-problems",
        "quta_static": f"{titled('quta')} as it comes",
    }
    aims = {"osqp_qpsolvers": Aim("ratio", ">=", 300.0), "quta": Aim("ratio", ">=", 100.0), "quta_static": None}
    alone = {"osqp_qpsolvers", "quta"}
    for name, aim in aims.items():
        row = f"{_ROW}_over_{name}"
        if name not in candidates:
            results.append(against(row, mine.median, f"not measured: {missing[name]}", None, aim))
            continue
        theirs = summarize(calls[name].times)
        note = f"its median {theirs.median:.0f} us, p99 {theirs.p99:.0f} us, {theirs.count} steps"
        if name == "quta_static":
            note += f"; {_static_verdict(vessel, steps, best, calls[name])}; no rate limits, no weights, by design"
        else:
            note += f"; {_verdict(name, recorded, best, calls[name], peers[name])}"
        # The aim is for like with like: the optimum alone where that is what the peer finds.
        results += [
            against(row, mine.median, titles[name], theirs.median, None if name in alone else aim, note),
            against(f"{row}_p99", mine.p99, titles[name], theirs.p99, None),
        ]
        if name in alone:
            results.append(against(f"{_ROW}_optimum_over_{name}", search.median, titles[name], theirs.median, aim))
    return results


def _ours(vessel: Vessel, steps: Sequence[Step]) -> Candidate:
    allocator = [start(vessel)]

    def prepare(step: Step) -> Step:
        if step is steps[0]:
            allocator[0] = start(vessel)
        return step

    return Candidate(prepare, lambda step: allocator[0].step(step.tau, step.dt))


def _brute_force(recorded: Sequence[SectorStep]) -> list[tuple[AllocationProblem, FloatArray, float]]:
    """Return cheapest problem, its variables and its cost (4.20) of every step, by the reference.

    Raises
    ------
    ValueError
        If a sub-problem could not be solved.
    """
    best = []
    for one in recorded:
        problems = sub_problems(one)
        answers = optima(problems)
        costs = [2.0 * problem.objective(z) for problem, z in zip(problems, answers, strict=True)]
        i = int(np.argmin(costs))
        best.append((problems[i], answers[i], costs[i]))
    return best


def _equal(recorded: Sequence[SectorStep], best: Sequence[tuple[AllocationProblem, FloatArray, float]]) -> Result:
    gaps = [abs(one.cost - cost) / max(cost, 1e-12) for one, (_, _, cost) in zip(recorded, best, strict=True)]
    return Result(
        f"{_ROW}_unequal_to_brute_force",
        float(sum(gap > _EQUAL for gap in gaps)),
        "steps",
        aim=Aim("value", "<=", 0.0),
        note=f"of {len(gaps)}; largest relative difference of the cost {max(gaps):.2g}",
    )


def _verdict(
    name: str,
    recorded: Sequence[SectorStep],
    best: Sequence[tuple[AllocationProblem, FloatArray, float]],
    calls: Calls,
    peer: Any,
) -> str:
    """Return what is wrong with a peer's answers, judged by the programs."""
    failed = bad = unsolved = 0
    largest = violation = 0.0
    for place, answer in zip(calls.places, calls.answers, strict=True):
        problems = sub_problems(recorded[place])
        if isinstance(answer, Exception):
            failed += 1
            continue
        if name == "quta":
            # It does not say which combination it took: the one that its answer fits best.
            fits = [_fit(problem, peer.forces(answer)) for problem in problems]
            excess, cost = min(fits)
        else:
            solved = [(problem, one.x) for problem, one in zip(problems, answer, strict=True) if one.found]
            unsolved += len(problems) - len(solved)
            if not solved:
                failed += 1
                continue
            problem, x = min(solved, key=lambda pair: pair[0].objective(pair[1][: pair[0].variables]))
            z = np.asarray(x[: problem.variables])
            excess, cost = _violation(problem, z), 2.0 * problem.objective(z)
        least = best[place][2]
        gap = abs(cost - least) / max(least, 1e-12)
        largest, violation = max(largest, gap), max(violation, excess)
        bad += gap > _BAD or excess > TOLERANCE
    text = (
        f"{failed} of {len(calls.places)} failed, {bad} with another cost (by more than {_BAD:g}) or a limit broken; "
        f"largest cost difference {largest:.2g}, violation {violation:.2g} N"
    )
    return text + (f"; {unsolved} sub-problems without an answer" if unsolved else "")


def _static_verdict(
    vessel: Vessel, steps: Sequence[Step], best: Sequence[tuple[AllocationProblem, FloatArray, float]], calls: Calls
) -> str:
    answers: list[Commands | None] = []
    for answer in calls.answers:
        if isinstance(answer, Exception):
            answers.append(None)
            continue
        forces = np.asarray(answer[0]).reshape(-1, 2)
        azimuth = np.arctan2(forces[:, 1], forces[:, 0])
        thrust = np.hypot(forces[:, 0], forces[:, 1])
        for j, turns in enumerate(vessel.can_rotate):
            if not turns:
                fixed = float(vessel.fixed_direction[j])
                thrust[j] = forces[j] @ [np.cos(fixed), np.sin(fixed)]
                azimuth[j] = fixed
        answers.append((thrust, azimuth))
    forces_wanted = [problem.B @ z for problem, z, _ in best]
    return str(judge(vessel, steps, forces_wanted, calls.places, answers, own_course=True))


def _fit(problem: AllocationProblem, forces: FloatArray) -> tuple[float, float]:
    """Return how far Cartesian thrusts, shape (n, 2), are from the limits of ``problem`` (N), and their cost there."""
    z, across = [], 0.0
    for i, j in enumerate(problem.fixed):
        along = problem.B[:2, i]
        z.append(float(forces[j] @ along))
        across = max(across, abs(float(forces[j, 0] * along[1] - forces[j, 1] * along[0])))
    for j in problem.rotating:
        z += forces[j].tolist()
    answer = np.array(z)
    return max(across, _violation(problem, answer)), 2.0 * problem.objective(answer)


def _violation(problem: AllocationProblem, z: FloatArray) -> float:
    """Return the largest violation of a bound or row, N."""
    k = problem.bounds
    return max(
        0.0,
        float((problem.A @ z - problem.b_upper[k:]).max(initial=0.0)),
        float((z[:k] - problem.b_upper[:k]).max(initial=0.0)),
        float((problem.b_lower[:k] - z[:k]).max(initial=0.0)),
    )
