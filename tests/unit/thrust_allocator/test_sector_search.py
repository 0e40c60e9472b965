"""The best combination of windows against all of them, and what the commands then do in sectors."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angle, wrap_angles
from marine_model.guards import FloatArray
from thrust_allocator import Allocator, AllocatorSettings, Phase
from thrust_allocator.plan.limits import limit_table
from thrust_allocator.program.active_set import polish, solve
from thrust_allocator.program.solvers import make_solver
from thrust_allocator.sectors import Reach, factor_at, path_to, vessel_sectors
from thrust_allocator.sectors.pieces import Pieces
from thrust_allocator.sectors.search import best_combination, sub_problem_cost
from thrust_allocator.settings import SectorSettings

# Called with their first arguments in a tuple.
_sub_problem_cost: Any = sub_problem_cost
_best_combination: Any = best_combination

VESSEL = load_vessel("cybership3")
DT = 0.2


def changed(kinds: str) -> Vessel:
    """CyberShip III with reduced sectors (``reduced``), or forbidden ones with a factor as well (``mixed``)."""
    document: dict[str, Any] = VESSEL.model_dump()
    for thruster in document["thrusters"]:
        for k, sector in enumerate((thruster.get("azimuth") or {}).get("sectors", ())):
            if kinds == "reduced" or (kinds == "mixed" and k):
                sector.update(kind="reduced", thrust_factor=0.3)
            elif kinds == "mixed":
                sector["thrust_factor"] = 0.2
    return Vessel.model_validate(document)


def cones(random: np.random.Generator, first: FloatArray, radius: float) -> tuple[Any, Any]:
    corners, count = np.zeros((int(first[-1]), 9, 2)), np.zeros(int(first[-1]), dtype=np.int64)
    for row in range(len(count)):
        start, width = random.uniform(-math.pi, math.pi), random.uniform(0.2, 3.1)
        k = int(random.integers(2, 9))
        angle = np.linspace(start, start + width, k)
        corners[row, 1 : k + 1] = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        count[row] = k + 1
    return corners, count


def cost_of(what: Any, choice: tuple[int, ...]) -> float:
    n = len(choice)
    return _sub_problem_cost(*what, np.array(choice), np.zeros(3), np.zeros((n, 2)))


def check_search(what: Any, reach: FloatArray, furthest: int) -> tuple[int, int]:
    first = what[6]
    n = len(first) - 1
    admitted = [[i for i in range(int(first[j + 1] - first[j])) if reach[first[j] + i] <= furthest] for j in range(n)]
    costs = {choice: cost_of(what, choice) for choice in product(*admitted)}
    start = next(iter(costs))
    multiplier, choice = np.zeros(3), np.array(start)
    _sub_problem_cost(*what, choice, multiplier, np.zeros((n, 2)))
    found, solved = _best_combination(*what, reach, furthest, np.inf, multiplier, choice)
    best = min(costs.values())
    # 1e-13 of the terms of a bound may be rounding, and bounds are differences.
    assert found == pytest.approx(best, rel=1e-9, abs=1e-9)
    assert costs[tuple(choice.tolist())] == pytest.approx(found, rel=1e-12)
    # With a limit at the optimum there is nothing better, and the choice stands.
    choice[:] = start
    again, _ = _best_combination(*what, reach, furthest, best * (1.0 - 1e-9) - 1e-9, multiplier, choice)
    assert again == best * (1.0 - 1e-9) - 1e-9
    assert tuple(choice.tolist()) == start
    return int(solved), len(costs)


def test_search_equals_all_combinations_of_the_vessel() -> None:
    random = np.random.default_rng(21)
    gains = VESSEL.allocator
    compliance = 1.0 / (gains.slack_gain * np.array(gains.slack_weight)) ** 2
    weight = np.array(gains.thrust_weight) ** 2
    columns = np.zeros((4, 3, 2))
    columns[:, 0, 0] = columns[:, 1, 1] = 1.0
    columns[:, 2, 0], columns[:, 2, 1] = -VESSEL.lever_y, VESSEL.lever_x
    thrusters = vessel_sectors(VESSEL)
    pieces = Pieces(thrusters)
    solved = every = 0
    for k in range(2000):
        if k % 20 == 0:
            settings = AllocatorSettings(
                azimuth_mode="rotating",
                thruster_enabled=(True, *(random.random(3) > 0.1).tolist()),
                thrust_limit_scale=tuple(random.choice([1.0, 0.5, 0.01, 0.0], 4).tolist()),
            )
            limits = limit_table(VESSEL, settings)
            pieces.limit(limits)
            pieces.hold(0, limits, math.pi / 2, 1.0)
        tau = random.normal(size=3) * [10.0, 8.0, 5.0] * random.choice([0.01, 0.2, 1.0])
        what = (columns, weight, compliance, tau, pieces.corners, pieces.count, pieces.first)
        reach = random.choice([0, 0, 1, 2], size=len(pieces.count))
        reach[pieces.first[:-1]] = Reach.FREE
        some, all_of_them = check_search(what, reach, int(random.integers(0, 3)))
        solved, every = solved + some, every + all_of_them
    assert solved < every  # bounds rule out some even where the search has no limit to begin with


def test_search_equals_all_combinations_of_random_vessels() -> None:
    random = np.random.default_rng(22)
    for _ in range(120):
        n = int(random.integers(4, 7))
        first = np.cumsum([0, *random.integers(2, 5 if n == 4 else 4 if n == 5 else 3, n)], dtype=np.int64)
        corners, count = cones(random, first, random.choice([1.0, 20.0]))
        columns = np.zeros((n, 3, 2))
        columns[:, 0, 0] = columns[:, 1, 1] = 1.0
        columns[:, 2] = random.normal(size=(n, 2))
        tau = random.normal(size=3) * random.choice([0.1, 5.0, 60.0])
        weight, compliance = random.uniform(0.5, 20.0, n), np.array([1e-6, 1e-6, 1e-8])
        what = (columns, weight, compliance, tau, corners, count, first)
        check_search(what, np.zeros(len(count), dtype=np.int64), 0)


def test_cost_of_a_combination_is_that_of_its_polygons() -> None:
    """By the duality gap of the polished answer, which needs no solver: cost and bound agree."""
    random = np.random.default_rng(23)
    for _ in range(300):
        first = np.array([0, 2, 4, 6], dtype=np.int64)
        corners, count = cones(random, first, 5.0)
        columns = np.zeros((3, 3, 2))
        columns[:, 0, 0] = columns[:, 1, 1] = 1.0
        columns[:, 2] = random.normal(size=(3, 2))
        tau, weight, compliance = random.normal(size=3) * 6.0, np.array([1.0, 2.0, 3.0]), np.full(3, 1e-6)
        choice = random.integers(0, 2, 3)
        cost = cost_of((columns, weight, compliance, tau, corners, count, first), tuple(choice.tolist()))
        rows = first[:3] + choice
        force, multiplier, face = np.zeros((3, 2)), np.zeros(3), np.zeros(3, dtype=np.int64)
        here = (columns, weight, np.ascontiguousarray(corners[rows]), count[rows], compliance, tau)
        assert solve(*here, multiplier, force, face, np.zeros((3, 4))) >= 0
        polish(*here, multiplier, force, face, np.zeros((3, 4)), np.zeros((3, 2)))
        gap = 0.0
        for j, row in enumerate(rows):
            downhill = columns[j].T @ multiplier - weight[j] * force[j]
            gap += max(0.0, float(((corners[row, : count[row]] - force[j]) @ downhill).max()))
        # Slack of 1e-15 N at a weight of 1e6, times corners of 5 N.
        assert gap <= 1e-9 * cost + 1e-6
        slack = tau - np.einsum("jix,jx->i", columns, force)
        assert cost == pytest.approx(float((slack**2).sum() * 1e6 + (weight[:, None] * force**2).sum()), rel=1e-9)


@pytest.mark.parametrize("kinds", ["forbidden", "reduced", "mixed"])
def test_commands_in_sectors_over_long_sequences(kinds: str) -> None:
    """With sectors switched off and on, azimuth drives failing and modes changing on the way."""
    vessel = changed(kinds)
    thrusters = vessel_sectors(vessel)
    random = np.random.default_rng(24)
    on = AllocatorSettings.for_vessel(vessel, azimuth_mode="rotating", sectors=SectorSettings(enabled=True))
    off = on.model_copy(update={"sectors": SectorSettings(enabled=False)})
    crossings = 0
    for _ in range(12):
        allocator = Allocator(vessel, on, None, random.uniform(-math.pi, math.pi, 4))
        before = allocator.step(np.zeros(3), DT)
        for _ in range(15):
            chosen = [on, on, on, on, off, "fixed", "failed"][random.integers(7)]
            if chosen == "fixed":
                chosen = on.model_copy(update={"azimuth_mode": "fixed"})
            elif chosen == "failed":
                chosen = on.model_copy(update={"azimuth_enabled": tuple((random.random(4) > 0.3).tolist())})
            allocator.apply(chosen)
            tau = random.normal(size=3) * random.choice([0.5, 3.0, 8.0]) * [1.0, 0.8, 0.4]
            for _ in range(random.integers(3, 25)):
                result = allocator.step(tau, DT)
                turn = wrap_angles(result.azimuth - before.azimuth)
                step = vessel.azimuth_rate * DT
                assert (np.abs(turn) <= step + 1e-9).all()
                for j in (1, 2, 3) if result.sectors is not None else ():
                    if result.phase[j] is not Phase.TURNING:  # to a fixed direction: the factor of where it was
                        most = factor_at(thrusters[j], result.azimuth[j]) * vessel.thrust_max[j]
                        least = before.thrust[j] - 0.9 * vessel.thrust_rate[j] * DT
                        assert result.thrust[j] <= max(most, least) + 1e-9
                    if result.phase[j] not in (Phase.ROTATING, Phase.CROSSING):
                        continue
                    inside = any(
                        abs(wrap_angle(result.azimuth[j] - arc.centre)) < arc.half_width - 1e-8
                        for arc in thrusters[j].forbidden
                    )
                    if inside:
                        assert result.phase[j] is Phase.CROSSING
                        assert abs(turn[j]) == pytest.approx(step[j], abs=1e-9)
                        crossings += 1
                    if result.phase[j] is Phase.ROTATING:
                        assert result.sectors is not None
                        window = thrusters[j].windows[result.sectors.windows[j]]
                        assert abs(wrap_angle(result.azimuth[j] - window.centre)) <= window.half_width + 1e-9
                before = result
    assert (crossings > 20) == (kinds != "reduced")


def reach_of(choice: tuple[int, ...], windows: tuple[int, ...], azimuth: FloatArray) -> int:
    worst = 0
    for j, thruster in enumerate(vessel_sectors(VESSEL)):
        if choice[j] != windows[j]:
            way = path_to(thruster, choice[j], azimuth[j])
            worst = max(worst, 2 if way.crosses else 0 if way.inside else 1)
    return worst


def test_rules_of_the_supervisor_hold_in_the_allocator() -> None:
    """Between two passages the dwell time; a turn only for a cost lower by the hysteresis; free windows at once."""
    random = np.random.default_rng(25)
    dwell, ratio = 3.0, 10.0**-0.04
    settings = AllocatorSettings(
        azimuth_mode="rotating", sectors=SectorSettings(enabled=True, hysteresis=0.04, dwell_time=dwell)
    )
    allocator = Allocator(VESSEL, settings)
    thrusters = vessel_sectors(VESSEL)
    pieces = Pieces(thrusters)
    limits = limit_table(VESSEL, settings)
    pieces.limit(limits)
    pieces.hold(0, limits, math.pi / 2, 1.0)
    gains = VESSEL.allocator
    compliance = 1.0 / (gains.slack_gain * np.array(gains.slack_weight)) ** 2
    weight = np.array(gains.thrust_weight) ** 2
    columns = np.zeros((4, 3, 2))
    columns[:, 0, 0] = columns[:, 1, 1] = 1.0
    columns[:, 2, 0], columns[:, 2, 1] = -VESSEL.lever_y, VESSEL.lever_x
    last_cross, switched = -math.inf, 0
    windows: tuple[int, ...] | None = None
    azimuth = VESSEL.fixed_direction
    for k in range(900):
        if k % 15 == 0:
            tau = random.normal(size=3) * [3.0, 2.5, 1.5]
        result = allocator.step(tau, DT)
        report = result.sectors
        assert report is not None
        what = (columns, weight, compliance, tau, pieces.corners, pieces.count, pieces.first)
        costs = {c: cost_of(what, c) for c in product(*(range(len(t.windows)) for t in thrusters))}

        if windows is not None:
            ways = {choice: reach_of(choice, windows, azimuth) for choice in costs}
            may_cross = k * DT - last_cross >= dwell - 1e-9
            free = min(cost for choice, cost in costs.items() if ways[choice] == 0)
            turning = min(
                (cost for choice, cost in costs.items() if ways[choice] == 1 or (may_cross and ways[choice] == 2)),
                default=math.inf,
            )
            expected = turning if turning < ratio * free else free
            if abs(turning - ratio * free) > 1e-6 * free:
                assert costs[report.windows] == pytest.approx(expected, rel=1e-8)
            if ways[report.windows] == 2:
                assert may_cross
                last_cross = k * DT
                switched += 1
        windows, azimuth = report.windows, result.azimuth
    assert switched > 3


def test_sectors_switched_on_again_begin_from_where_the_thrusters_are() -> None:
    """A window chosen before they were off is no reason to turn back to it."""
    on = AllocatorSettings(azimuth_mode="rotating", sectors=SectorSettings(enabled=True, dwell_time=3600.0))
    off = AllocatorSettings(azimuth_mode="rotating")
    allocator = Allocator(VESSEL, on)
    for _ in range(60):
        allocator.step([0.0, 3.0, 0.0], DT)
    allocator.apply(off)
    for _ in range(60):
        before = allocator.step([0.0, -3.0, 0.0], DT)
    allocator.apply(on)
    # Nothing is demanded, so that no window costs less than another.
    result = allocator.step(np.zeros(3), DT)
    assert result.sectors is not None
    for j, thruster in enumerate(vessel_sectors(VESSEL)):
        if any(abs(wrap_angle(before.azimuth[j] - w.centre)) <= w.half_width for w in thruster.windows):
            assert not result.sectors.crossing[j]
    # One that stands in no window, the sector from 70 to 110 deg, is led out.
    assert any(result.sectors.crossing)


def test_no_demand_turns_nothing() -> None:
    """Without a demand costs are rounding, from 1e-60 to 0, and one is many times lower than another."""
    settings = AllocatorSettings(
        azimuth_mode="rotating", sectors=SectorSettings(enabled=True, dwell_time=0.0, hysteresis=0.0)
    )
    allocator = Allocator(VESSEL, settings)
    for tau in ([0.0, 3.0, 0.0], [-2.0, 1.0, 0.5], [1.0, -2.0, 0.3]):
        for _ in range(60):
            before = allocator.step(tau, DT)
        for _ in range(10):
            result = allocator.step(np.zeros(3), DT)
            assert result.sectors is not None
            assert before.sectors is not None
            assert result.sectors.windows == before.sectors.windows


def test_cheapest_windows_are_those_of_all_sub_problems_and_change_nothing() -> None:
    vessel = load_vessel("cybership3")
    settings = AllocatorSettings.for_vessel(vessel, azimuth_mode="rotating", sectors=SectorSettings(enabled=True))
    asked, other = Allocator(vessel, settings), Allocator(vessel, settings)
    random, solver = np.random.default_rng(3), make_solver("daqp")
    for _ in range(40):
        tau = random.normal(size=3) * [8.0, 6.0, 4.0]
        np.testing.assert_array_equal(asked.step(tau, 0.2).commands, other.step(tau, 0.2).commands)
        costs = []
        for problem in asked.sub_problems():
            solution = solver.solve(problem)
            assert solution is not None
            costs.append(2.0 * problem.objective(solution.z))
        cost, windows = asked.cheapest_windows(tau)
        assert len(costs) == 18
        assert cost == pytest.approx(min(costs), rel=1e-9)
        number = 9 * windows[1] + 3 * windows[2] + windows[3]
        assert costs[number] == pytest.approx(cost, rel=1e-9)
    with pytest.raises(InputError, match="tau_desired"):
        asked.cheapest_windows([1.0, 2.0])
