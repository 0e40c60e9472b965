"""Vessels, sub-problems, random instances and exponents of the benchmarks of the allocator."""

from pathlib import Path

import numpy as np
import pytest

import benchmarks.accuracy
from benchmarks.accuracy import examine, measure_accuracy
from benchmarks.allocation import measure_allocation
from benchmarks.demands import demand_in_waves
from benchmarks.fleet import with_thrusters, with_windows
from benchmarks.gain_map import measure_gain_map
from benchmarks.plan import quick
from benchmarks.printout import _number
from benchmarks.reference import optima
from benchmarks.scaling import exponent
from benchmarks.sectors import measure_sectors
from benchmarks.sub_problems import record_sectors, sub_problems, window_counts
from marine_model import load_vessel
from marine_model.frames import wrap_angle
from thrust_allocator.sectors import vessel_sectors

VESSEL = load_vessel("cybership3")


@pytest.mark.parametrize("count", [4, 8, 16, 32])
def test_a_vessel_with_more_thrusters_is_as_strong_and_they_are_elsewhere(count: int) -> None:
    vessel = with_thrusters(VESSEL, count)
    assert len(vessel.thrusters) == count
    assert vessel.thrust_max.sum() == pytest.approx(VESSEL.thrust_max.sum())
    assert vessel.thruster_names[:4] == VESSEL.thruster_names
    places = np.column_stack([vessel.lever_x, vessel.lever_y])
    distances = np.linalg.norm(places[:, None] - places[None], axis=-1) + np.eye(count)
    assert distances.min() > 1e-3
    assert np.abs(vessel.lever_x).max() <= 0.5 * VESSEL.hull.length
    assert np.abs(vessel.lever_y).max() <= 0.5 * VESSEL.hull.beam


@pytest.mark.parametrize("count", [2, 6])
def test_other_numbers_of_thrusters_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match=f"count: expected a multiple of 4, found {count}"):
        with_thrusters(VESSEL, count)


def test_every_step_has_18_sub_problems_and_the_cheapest_is_chosen() -> None:
    for one in record_sectors(VESSEL, 1.5 * demand_in_waves(VESSEL, 25, 9), 0.2):
        problems = sub_problems(one)
        assert len(problems) == 18
        costs = [2.0 * problem.objective(z) for problem, z in zip(problems, optima(problems), strict=True)]
        assert one.cost == pytest.approx(min(costs), rel=1e-9, abs=1e-12)


def test_thrusters_are_outside_of_their_windows_only_to_cross() -> None:
    steps = [one.step for one in record_sectors(VESSEL, 1.5 * demand_in_waves(VESSEL, 150, 10), 0.2)]
    crossing = 0
    sectors = vessel_sectors(VESSEL)
    for step in steps:
        for j in (1, 2, 3):
            angle = float(step.azimuth[j])
            inside = any(abs(wrap_angle(angle - w.centre)) <= w.half_width + 1e-6 for w in sectors[j].windows)
            if not inside:
                crossing += 1
                turn = abs(wrap_angle(angle - float(step.azimuth_before[j])))
                least = float(VESSEL.azimuth_rate[j]) * step.dt
                assert turn >= least - 1e-9
    assert crossing > 0


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_vessel_with_windows_has_them_about_its_fixed_directions(count: int) -> None:
    vessel = with_windows(VESSEL, count)
    assert window_counts(vessel) == [1, count, count, count]
    for sectors, direction in list(zip(vessel_sectors(vessel), vessel.fixed_direction, strict=True))[1:]:
        offsets = [abs(wrap_angle(window.centre - float(direction))) for window in sectors.windows]
        assert min(offsets) < 1e-9
        assert max(window.half_width for window in sectors.windows) < 0.5 * np.pi


def test_random_instances_follow_from_their_seed_and_are_answered() -> None:
    first, again = (examine("cybership3", 200, (1, 2)) for _ in range(2))
    assert first == again
    assert (first.instances, first.failures, first.unverified) == (200, 0, 0)
    assert first.saturated > 100
    assert first.cost_gap <= 1e-9
    assert max(first.program_violation, first.command_violation, first.balance_error) <= 1e-9


def test_a_wrong_answer_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = benchmarks.accuracy.program_answer

    def spoiled(allocator, problem):
        z = answer(allocator, problem)
        return None if z is None else z + 1e-6

    monkeypatch.setattr(benchmarks.accuracy, "program_answer", spoiled)
    found = examine("cybership3", 200, (1, 2))
    assert found.cost_gap > 1e-9
    assert found.program_violation > 1e-9


def test_no_answer_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmarks.accuracy, "program_answer", lambda allocator, problem: None)
    assert examine("cybership3", 40, (1, 2)).failures == 40


@pytest.mark.parametrize("power", [0.0, 0.7, 1.0])
def test_exponent_of_a_power_law(power: float) -> None:
    sizes = [4, 8, 16, 32]
    assert exponent(sizes, [3.0 * size**power for size in sizes]) == pytest.approx(power, abs=1e-12)


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, ""), (0.0, "0.00"), (3.2e-13, "3.2e-13"), (0.0301, "0.03"), (17.46, "17.5"), (1234.4, "1234")],
)
def test_numbers_keep_their_digits(value: float | None, text: str) -> None:
    assert _number(value) == text


@pytest.mark.timeout(300)
@pytest.mark.parametrize("measure", [measure_allocation, measure_sectors, measure_accuracy])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_quick_measurement_gives_rows_with_unlike_names(measure, tmp_path: Path) -> None:
    done: list[tuple[int, int]] = []
    plan = quick(tmp_path)
    plan = type(plan)(
        **{name: getattr(plan, name) for name in plan.__slots__}
        | {"accuracy_instances": 100, "progress": lambda now, total: done.append((now, total))}
    )
    rows = measure(plan)
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert any(row.aim is not None for row in rows)
    assert done
    assert done[-1][0] == done[-1][1]


def test_the_map_is_numpys(tmp_path: Path) -> None:
    rows = {row.name: row for row in measure_gain_map(quick(tmp_path))}
    assert rows["gain_map_bidirectional"].peer_value is not None
    difference = float(rows["gain_map_bidirectional"].note.rpartition(" ")[2])
    # Rounding near singular configurations, where a singular value is the root of a small number.
    assert difference < 1e-6
