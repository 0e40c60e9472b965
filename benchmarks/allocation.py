"""One full step of the allocator beside what else could be used, on the same steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.blocks import Calls, Candidate, in_turn
from benchmarks.demands import Step, record, saturated_share, sequence, starter
from benchmarks.peers.ipopt_peer import Ipopt
from benchmarks.peers.osqp_peer import NativeOsqp, OsqpThroughQpsolvers
from benchmarks.peers.peer import Commands, Peer, PeerMissingError
from benchmarks.peers.pseudo_inverse_peer import PseudoInverse
from benchmarks.peers.slsqp_peer import Slsqp
from benchmarks.plan import Plan
from benchmarks.reference import optima
from benchmarks.result import Aim, Result
from benchmarks.statistics import Summary, summarize
from benchmarks.verdict import Verdict, judge
from marine_model import Vessel, load_vessel
from thrust_allocator import Allocator, AllocatorSettings

RATE = "steps/s"

_SEED = 20
_OURS = "ours"
# By name: how to make it, the share of the steps it is given (slow ones would take the whole time), and its aim.
_Factory = Callable[[Vessel, bool], Peer]
_PEERS: Mapping[str, tuple[_Factory, float, Aim | None]] = {
    "osqp_qpsolvers": (lambda vessel, rotating: OsqpThroughQpsolvers(), 0.25, Aim("ratio", ">=", 30.0)),
    "osqp_qpsolvers_default": (lambda vessel, rotating: OsqpThroughQpsolvers(fair=False), 0.25, None),
    "osqp_native": (lambda vessel, rotating: NativeOsqp(), 0.25, None),
    "slsqp": (lambda vessel, rotating: Slsqp(), 0.1, None),
    "casadi_ipopt": (Ipopt, 0.1, None),
    "mcsimpython": (PseudoInverse, 1.0, None),
}


def measure_allocation(plan: Plan) -> list[Result]:
    """Measure steps with fixed and with rotating azimuth thrusters."""
    vessel = load_vessel(plan.vessel)
    results: list[Result] = []
    for mode in ("fixed", "rotating"):
        settings = AllocatorSettings(azimuth_mode=mode)
        count = plan.allocation_blocks * plan.allocation_steps
        demands = sequence(vessel, starter(vessel, settings), count, _SEED)
        steps = record(vessel, settings, demands.demands, demands.dt)
        results += _compare(plan, vessel, settings, steps)
    return results


def ours(vessel: Vessel, settings: AllocatorSettings, steps: list[Step]) -> Candidate:
    """Return our allocator as a candidate for ``steps``; it starts anew at the first of them."""
    allocator = Allocator(vessel, settings)

    def prepare(step: Step) -> Step:
        if step is steps[0]:
            allocator.reset(step.thrust_before, step.azimuth_before)
        return step

    return Candidate(prepare, lambda step: allocator.step(step.tau, step.dt))


def _compare(plan: Plan, vessel: Vessel, settings: AllocatorSettings, steps: list[Step]) -> list[Result]:
    mode = settings.azimuth_mode
    peers: dict[str, Peer] = {}
    missing: dict[str, str] = {}
    for name, (factory, _, _) in _PEERS.items():
        try:
            peers[name] = factory(vessel, mode == "rotating")
        except PeerMissingError as error:
            missing[name] = str(error)

    def read(name: str, step: Step, answer: Any) -> Commands | None:
        return (answer.thrust, answer.azimuth) if name == _OURS else peers[name].commands(step, answer)

    candidates = {_OURS: ours(vessel, settings, steps)}
    candidates |= {name: Candidate(peer.prepare, peer.solve, _PEERS[name][1]) for name, peer in peers.items()}
    calls = in_turn(candidates, steps, plan.allocation_blocks, read, plan.progress)
    answers = optima([step.problem for step in steps])
    optimum = [step.problem.B @ z for step, z in zip(steps, answers, strict=True)]

    def verdict(name: str) -> Verdict:
        seen = calls[name]
        given = [None if isinstance(answer, Exception) else answer for answer in seen.answers]
        return judge(vessel, steps, optimum, seen.places, given, own_course=name == "mcsimpython")

    mine = summarize(calls[_OURS].times)
    own = verdict(_OURS)
    row = f"allocation_{mode}"
    note = (
        f"{len(steps)} steps of a closed loop in waves, {saturated_share(vessel, steps):.0%} saturated, "
        f"{plan.allocation_blocks} blocks in turn with the peers'"
    )
    results = [
        Result(f"{row}_median", mine.median, "us", note=f"{note}; build, solve, polar form, status; {own}"),
        p99(f"{row}_p99", calls[_OURS]),
        Result(
            f"{row}_cold",
            summarize(calls[_OURS].cold).median,
            "us",
            note="first call of a block, after the others had the processor's caches; not part of the two above",
        ),
    ]
    for name, (_, _, aim) in _PEERS.items():
        if name in missing:
            results.append(against(f"{row}_over_{name}", mine.median, f"not measured: {missing[name]}", None, aim))
            continue
        results += _rows(row, peers[name], calls[name], mine, verdict(name), own, aim)
    return results


def against(name: str, mine: float, title: str, theirs: float | None, aim: Aim | None, note: str = "") -> Result:
    """Return a row of rates, from times in us: its ratio says how many times as fast we are."""
    return Result(name, 1e6 / mine, RATE, title, None if theirs is None else 1e6 / theirs, aim, note)


def p99(name: str, calls: Calls) -> Result:
    """Return the row of the slowest hundredth of our steps, beside their median."""
    clock, busy = summarize(calls.times), summarize(calls.busy)
    note = f"by processor time, without what else the machine did: median {busy.median:.1f} us, p99 {busy.p99:.1f} us"
    return Result(name, clock.p99, "us", "its own median", clock.median, Aim("ratio", "<=", 4.0), note)


def _rows(
    row: str, peer: Peer, calls: Calls, mine: Summary, verdict: Verdict, own: Verdict, aim: Aim | None
) -> list[Result]:
    """Return rate at the median, rate at the 99th percentile, and share of bad steps beside ours."""
    theirs = summarize(calls.times)
    by_design = f"; {peer.remark}" if peer.remark else ""
    return [
        against(
            f"{row}_over_{peer.name}",
            mine.median,
            peer.title,
            theirs.median,
            aim,
            f"its median {theirs.median:.0f} us, p99 {theirs.p99:.0f} us, cold {summarize(calls.cold).median:.0f} us, "
            f"{len(calls.places)} steps",
        ),
        against(f"{row}_over_{peer.name}_p99", mine.p99, peer.title, theirs.p99, None),
        Result(
            f"{row}_bad_steps_{peer.name}",
            100.0 * own.bad_steps / own.steps,
            "% of steps",
            peer.title,
            100.0 * verdict.bad_steps / verdict.steps,
            None,
            f"{verdict}{by_design}",
        ),
    ]
