"""A great many random problems: how far the allocator's answers are from the optimum, and whether it ever fails."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from benchmarks.demands import by_decades, strength
from benchmarks.plan import Plan
from benchmarks.reference import Batch, optimum
from benchmarks.result import Aim, Result
from marine_model import Vessel, load_vessel
from marine_model.guards import FloatArray
from thrust_allocator import Allocator, AllocatorSettings
from thrust_allocator.program.problem import AllocationProblem

_SEED = 22
_CHUNK = 2_000  # instances a task; each task has one vessel state (mode, failures), or a few of the small ones
_STATES_PER_CHUNK = 4
_TIME_STEPS = (0.02, 0.2, 0.3)  # s: a simulator's, a controller's, the longest of one that is late
_DEMAND_RANGE = (1e-4, 3.0)  # of the vessel's strength, by decades
_AIM = Aim("value", "<=", 1e-9)
# Costs are compared relative to the optimum's, or to this share of the cost of all thrust where that is larger: at
# rest the optimum is zero.
_COST_FLOOR = 1e-9


@dataclass(frozen=True, slots=True)
class Findings:
    """The worst of some instances. Forces in N and N m, angles in rad."""

    instances: int = 0
    failures: int = 0  # no answer, or another status than optimal
    unverified: int = 0  # the reference has no answer that passes its own check
    saturated: int = 0  # some limit is active
    cost_gap: float = 0.0  # relative, of the program
    program_violation: float = 0.0
    command_violation: float = 0.0  # of thrust, thrust rate and azimuth rate limits, by the commands
    balance_error: float = 0.0  # B(azimuth) thrust + slack - tau
    polar_loss: float = 0.0  # largest component of the force between the program's answer and the commands

    def with_(self, other: Findings) -> Findings:
        """Return both together."""
        values = {}
        for field in fields(self):
            mine, theirs = getattr(self, field.name), getattr(other, field.name)
            values[field.name] = mine + theirs if isinstance(mine, int) else max(mine, theirs)
        return Findings(**values)


def measure_accuracy(plan: Plan) -> list[Result]:
    """Solve ``plan.accuracy_instances`` random problems in one process a core."""
    total = plan.accuracy_instances
    sizes = [_CHUNK] * (total // _CHUNK) + ([total % _CHUNK] if total % _CHUNK else [])
    found = Findings()
    workers = len(os.sched_getaffinity(0))
    # Processes started anew: a copy of this one would share its threads' locks.
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        tasks = [pool.submit(examine, plan.vessel, size, (_SEED, i)) for i, size in enumerate(sizes)]
        for task in as_completed(tasks):
            found = found.with_(task.result())
            plan.progress(found.instances, total)
    note = (
        f"{found.instances} random steps, {found.saturated / found.instances:.0%} with an active limit; "
        f"reference: daqp's active set, solved with 64 bits of digits; {found.unverified} without a verified reference"
    )
    return [
        Result("accuracy_failures", float(found.failures), "steps", aim=Aim("value", "<=", 0.0), note=note),
        Result("accuracy_cost_gap", found.cost_gap, "relative", aim=_AIM),
        Result(
            "accuracy_violation",
            max(found.program_violation, found.command_violation),
            "N, rad",
            aim=_AIM,
            note=f"of the program {found.program_violation:.2g} N, by the commands {found.command_violation:.2g}",
        ),
        Result(
            "accuracy_balance_error",
            found.balance_error,
            "N, N m",
            aim=_AIM,
            note="B(azimuth) thrust + slack - tau",
        ),
        Result(
            "accuracy_unverified",
            float(found.unverified),
            "steps",
            aim=Aim("value", "<=", 0.0),
            note="of the reference, not of the allocator",
        ),
        Result(
            "accuracy_polar_loss",
            found.polar_loss,
            "N, N m",
            note="most that the force changes when directions are brought into their windows after the program, 4.4.2",
        ),
    ]


def examine(vessel_name: str, count: int, seed: tuple[int, int]) -> Findings:
    """Return the findings on ``count`` random instances that follow from ``seed``."""
    vessel = load_vessel(vessel_name)
    draw = np.random.default_rng(seed)
    found = Findings()
    rest = count
    for state in range(_STATES_PER_CHUNK):
        size = rest // (_STATES_PER_CHUNK - state)
        rest -= size
        if size:
            found = found.with_(_examine_state(vessel, _random_settings(vessel, draw), size, draw))
    return found


def _random_settings(vessel: Vessel, draw: np.random.Generator) -> AllocatorSettings:
    """Return a mode with all thrusters whole, or with lost, stuck and weakened ones, but for all lost."""
    n = len(vessel.thrusters)
    mode: Literal["fixed", "rotating"] = "rotating" if draw.random() < 0.5 else "fixed"
    if draw.random() < 0.5:
        return AllocatorSettings(azimuth_mode=mode)
    enabled = draw.random(n) < 0.8
    enabled[draw.integers(n)] = True
    turning = draw.random(n) < 0.8
    scale = np.where(draw.random(n) < 0.5, 1.0, draw.uniform(0.1, 1.0, n))
    return AllocatorSettings(
        azimuth_mode=mode,
        thruster_enabled=tuple(enabled.tolist()),
        azimuth_enabled=tuple(turning.tolist()),
        thrust_limit_scale=tuple(scale.tolist()),
    )


def program_answer(allocator: Allocator, problem: AllocationProblem) -> FloatArray | None:
    """Return the variables that the last step's program was answered with, shape (m,); None without an answer."""
    # Not by `allocator.solution`, which builds the problem once more and judges it: three times the time of the step.
    answer = allocator.answer
    if answer is None or answer.complaint:
        return None
    force = answer.force
    along = (problem.B[:2, : problem.bounds].T * force[list(problem.fixed)]).sum(axis=1)
    return np.concatenate([along, force[list(problem.rotating)].ravel()])


def _examine_state(vessel: Vessel, settings: AllocatorSettings, count: int, draw: np.random.Generator) -> Findings:
    allocator = Allocator(vessel, settings)
    n = len(vessel.thrusters)
    scale = np.array(settings.thrust_limit_scale or (1.0,) * n)
    low, high = scale * vessel.thrust_min, scale * vessel.thrust_max
    thrusts = _operating_thrusts(low, high, settings.azimuth_mode == "rotating", draw, count)
    angles = draw.uniform(-np.pi, np.pi, (count, n))
    size = by_decades(draw, _DEMAND_RANGE, (count, 1)) * (draw.random((count, 1)) > 0.02)
    demands = size * draw.normal(size=(count, 3)) * strength(vessel)
    time_steps = draw.choice(_TIME_STEPS, count)
    groups: dict[tuple[tuple[int, ...], tuple[int, ...]], list[tuple[AllocationProblem, FloatArray]]] = {}
    answered: list[int] = []
    answers: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
    for i, (thrust, azimuth, tau, dt) in enumerate(zip(thrusts, angles, demands, time_steps.tolist(), strict=True)):
        try:
            allocator.reset(thrust, azimuth)
            result = allocator.step(tau, dt)
        except Exception:  # whatever it raises on good input is a failure
            continue
        problem = allocator.problem
        z = None if problem is None else program_answer(allocator, problem)
        if result.status != "optimal" or problem is None or z is None:
            continue
        answered.append(i)
        answers.append((result.thrust.copy(), result.azimuth.copy(), result.slack, problem.B @ z))
        groups.setdefault((problem.fixed, problem.rotating), []).append((problem, z))
    found = Findings(count, count - len(answered))
    if answered:
        # Lost thrusters are ramped down and count for nothing.
        counted = np.array(settings.thruster_enabled or (True,) * n)
        thrust, azimuth, slack, wanted = (np.array(column) for column in zip(*answers, strict=True))
        force = _force(vessel, thrust * counted, azimuth)
        before = (thrusts[answered], angles[answered])
        change = vessel.thrust_rate * time_steps[answered, None]
        turn = np.abs((azimuth - before[1] + np.pi) % (2.0 * np.pi) - np.pi) - (
            vessel.azimuth_rate * time_steps[answered, None]
        )
        excess = np.maximum(np.maximum(thrust - high, low - thrust), np.abs(thrust - before[0]) - change)
        excess = np.maximum(excess, np.where(vessel.can_rotate, turn, 0.0))
        found = found.with_(
            Findings(
                balance_error=float(np.abs(force + slack - demands[answered]).max()),
                command_violation=max(0.0, float(excess.max())),
                polar_loss=float(np.abs(force - wanted).max()),
            )
        )
    floor = _COST_FLOOR * float(np.square(vessel.thrust_max * np.array(vessel.allocator.thrust_weight)).sum())
    for members in groups.values():
        found = found.with_(_compare(members, floor))
    return found


def _force(vessel: Vessel, thrust: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return B(azimuth) thrust of many commands, shapes (N, n): shape (N, 3)."""
    x, y = thrust * np.cos(azimuth), thrust * np.sin(azimuth)
    moment = vessel.lever_x * y - vessel.lever_y * x
    return np.column_stack([x.sum(axis=1), y.sum(axis=1), moment.sum(axis=1)])


def _operating_thrusts(
    low: FloatArray, high: FloatArray, rotating: bool, draw: np.random.Generator, count: int
) -> FloatArray:
    """Return thrusts within the limits, some of them at zero or at a limit: shape (count, n)."""
    least = np.zeros_like(low) if rotating and draw.random() < 0.8 else low
    thrusts = draw.uniform(least, high, (count, len(low)))
    kind = draw.random(thrusts.shape)
    thrusts = np.where(kind < 0.1, 0.0, thrusts)
    return np.where(kind > 0.95, high, np.where(kind > 0.9, least, thrusts))


def _compare(members: list[tuple[AllocationProblem, FloatArray]], floor: float) -> Findings:
    """Return the findings on instances of one form."""
    batch = Batch.of([problem for problem, _ in members])
    z = np.array([answer for _, answer in members])
    best = optimum(batch)
    least = best.cost.astype(np.float64)
    mine = batch.cost(z)
    gap = np.abs((mine - best.cost).astype(np.float64)) / np.maximum(least, floor)
    inside = np.einsum("npm,nm->np", batch.C, z)
    near = 1e-9
    active = ((inside >= batch.upper - near) | (inside <= batch.lower + near)).any(axis=1)
    good = best.verified
    return Findings(
        unverified=int((~good).sum()),
        saturated=int(active.sum()),
        cost_gap=float(gap[good].max(initial=0.0)),
        program_violation=float(batch.violation(z).max(initial=0.0)),
    )
