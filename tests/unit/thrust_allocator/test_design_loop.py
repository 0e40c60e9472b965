"""The design loop on [Ruth] section 7.6: Tables 7.1 and 7.2, power buses, maps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from thrust_allocator.design.loop import MOST_THRUSTERS, bus_losses, study, study_rows
from thrust_allocator.design.maps import MapCase, map_cases, work_out

VESSEL = load_vessel("cybership3_ch7")
FREE = study(VESSEL)


def with_thrusters(thrusters: list[dict[str, Any]]) -> Vessel:
    """The vessel with other thrusters, on no power bus."""
    document = VESSEL.model_dump() | {"thrusters": thrusters, "power": {}}
    document["allocator"]["thrust_weight"] = [1.0] * len(thrusters)
    document["drivers"]["ventilation"]["speed_min"] = [5.0] * len(thrusters)
    return Vessel.model_validate(document)


FIXED = study(VESSEL, np.radians([90.0, 35.0, -45.0, 45.0]))

# Enabled thrusters: rank, minimum gain with the vessel's thrusts, with equal ones; None where the print has a dash.
TABLE_7_2 = {
    "1234": (3, 1.20, 1.73),
    "123": (3, 1.17, 1.40),
    "124": (3, 1.17, 1.40),
    "134": (3, 0.23, 1.41),
    "234": (3, 1.19, 1.21),
    "12": (3, 0.02, 0.20),
    "13": (3, 0.09, 0.99),
    "14": (3, 0.09, 0.99),
    "23": (3, 1.17, 1.19),
    "24": (3, 1.17, 1.19),
    "34": (3, 0.22, 0.15),
    "1": (1, None, None),
    "2": (2, None, None),
    "3": (2, None, None),
    "4": (2, None, None),
}
TABLE_7_1 = {"1234": 1.17, "234": 0.50, "134": 1.00, "124": 0.50, "123": 0.68}


def indices(numbers: str) -> list[int]:
    return [int(number) - 1 for number in numbers]


@pytest.mark.parametrize("enabled", TABLE_7_2)
def test_table_7_2(enabled: str) -> None:
    rank, gain, equal_gain = TABLE_7_2[enabled]
    row = FREE.of(indices(enabled))
    assert row.rank == rank
    # The lever arms behind the table are known to two or three digits: one unit of the last printed digit.
    assert row.gain == pytest.approx(gain or 0.0, abs=0.01)
    assert row.equal_gain == pytest.approx(equal_gain or 0.0, abs=0.01)


@pytest.mark.parametrize("enabled", TABLE_7_1)
def test_table_7_1(enabled: str) -> None:
    assert FIXED.of(indices(enabled)).equal_gain == pytest.approx(TABLE_7_1[enabled], abs=0.01)


def test_every_combination_comes_once_and_single_failures_are_marked() -> None:
    assert len({row.thrusters for row in FREE.combinations}) == len(FREE.combinations) == 15
    assert FREE.combinations[0].thrusters == (0, 1, 2, 3)
    lost = {row.lost: row.thrusters for row in FREE.combinations if row.lost is not None}
    assert lost == {0: (1, 2, 3), 1: (0, 2, 3), 2: (0, 1, 3), 3: (0, 1, 2)}


def test_best_split_is_that_of_the_thesis() -> None:
    best = FREE.best_splits(equal_thrust=True)
    assert {split.buses for split in best} == {((0, 2), (1, 3)), ((0, 3), (1, 2))}
    for split in best:
        assert split.equal_gain == pytest.approx(0.99, abs=0.01)
    # All splits, each once: 2^(4 - 1) - 1.
    assert len({split.buses for split in FREE.splits}) == len(FREE.splits) == 7
    for split in FREE.splits:
        assert sorted(split.buses[0] + split.buses[1]) == [0, 1, 2, 3]
        assert split.gain == min(FREE.of(bus).gain for bus in split.buses)
    assert FIXED.splits == ()


def test_no_best_split_where_one_bus_always_fails() -> None:
    # Two thrusters: each alone cannot produce every force.
    found = study(with_thrusters(VESSEL.model_dump()["thrusters"][1:3]))
    assert len(found.splits) == 1
    assert found.best_splits(equal_thrust=True) == found.best_splits(equal_thrust=False) == ()


def test_ball_beside_its_bounds() -> None:
    """[Ruth] (7.119) prints 6.0; 8.5 without 1 / sqrt 2; the exact radius is larger than either."""
    ball = FREE.ball
    assert ball.printed == pytest.approx(6.0, abs=0.05)
    assert ball.without_root == pytest.approx(8.5, abs=0.05)
    assert ball.reversible == pytest.approx(12.46, abs=0.005)
    # The tunnel is weaker astern.
    assert ball.without_root is not None
    assert ball.without_root < ball.exact < ball.reversible
    assert FIXED.ball.without_root is None
    assert FIXED.ball.printed <= FIXED.ball.reversible


def test_scaled_ball_is_no_smaller_than_the_gain_if_thrust_reverses_fully() -> None:
    """[Ruth] Theorem 7.3, and Lemma 7.2 without its factor."""
    document = VESSEL.model_dump()
    for thruster in document["thrusters"]:
        thruster["thrust"]["min"] = -thruster["thrust"]["max"]
    even = Vessel.model_validate(document)
    for azimuth in (None, [0.0, 0.6, -0.8, 0.8]):
        for row in study_rows(even, azimuth):
            assert row.scaled_ball >= row.gain * (1.0 - 1e-9)


def test_a_tunnel_keeps_its_direction() -> None:
    found = study(VESSEL, [0.0, 0.6, -0.8, 0.8])
    assert found.azimuth is not None
    assert found.azimuth[0] == math.pi / 2
    assert found.of([0, 1, 2, 3]).gain == study(VESSEL, [math.pi / 2, 0.6, -0.8, 0.8]).of([0, 1, 2, 3]).gain


def test_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match=r"azimuth: expected shape \(4,\)"):
        study(VESSEL, [0.0, 1.0])
    with pytest.raises(InputError, match=r"thrusters: expected some of the vessel's, found \[0, 9\]"):
        FREE.of([0, 9])
    azimuth = VESSEL.model_dump()["thrusters"][1]
    many = [azimuth | {"name": f"azimuth_{j}", "position": (float(j), 0.5, 0.0)} for j in range(MOST_THRUSTERS + 1)]
    with pytest.raises(InputError, match="expected at most 12 thrusters for all combinations, found 13"):
        study(with_thrusters(many))


def case_of(source: str, method: str = "svd") -> MapCase:
    return next(case for case in map_cases(VESSEL) if case.source == source and case.method == method)


def test_maps_are_those_of_figures_7_4_to_7_13() -> None:
    cases = map_cases(VESSEL)
    assert {case.source for case in cases} == {"", *(f"7.{number}" for number in range(4, 14))}
    assert [case.axes for case in cases if case.source == "7.9"] == [(1, 3)]
    assert all(case.axes == (2, 3) for case in cases if case.lost in (None, 0, 1))


@pytest.mark.parametrize(("source", "held"), [("7.4", 0.0), ("7.5", 90.0), ("7.10", 0.0), ("7.11", 90.0)])
def test_maps_against_singular_values(source: str, held: float) -> None:
    case = case_of(source)
    found = work_out(VESSEL, case, points=9)
    arm = np.hypot(VESSEL.lever_x, VESSEL.lever_y).mean()
    share = np.ones(4) if case.equal_thrust else VESSEL.thrust_max / VESSEL.thrust_max.mean()
    for i, one in enumerate(found.angles):
        for k, other in enumerate(found.angles):
            azimuth = np.array([math.pi / 2, math.radians(held), one, other])
            c, s = np.cos(azimuth), np.sin(azimuth)
            matrix = np.array([c, s, (VESSEL.lever_x * s - VESSEL.lever_y * c) / arm]) * share
            # Rounding of the squares of singular values of size 1: 1e-16 under a root.
            assert found.gain[i, k] == pytest.approx(np.linalg.svd(matrix, compute_uv=False)[2], abs=2e-8)


def test_what_the_thesis_reads_off_its_maps() -> None:
    # Equal thrusts: the forward azimuth is best at 0 deg; with the ship's own, whose tunnel is weak, at 90 deg.
    gains = {source: work_out(VESSEL, case_of(source)).gain for source in ("7.4", "7.5", "7.6", "7.7", "7.10", "7.11")}
    assert gains["7.4"].max() > gains["7.5"].max()
    assert gains["7.11"].max() > gains["7.10"].max()
    # Loss of the tunnel: nearly singular at 0 deg, hardly felt at 90 deg.
    assert gains["7.6"].max() < 0.2
    assert gains["7.7"].max() > 0.85 * gains["7.5"].max()


def test_theorem_7_2_is_never_below_theorem_7_1() -> None:
    for source in ("7.12", "7.13"):
        simple, better = (
            work_out(VESSEL, case_of(source, name), points=25).gain for name in ("theorem_7_1", "theorem_7_2")
        )
        assert (better >= simple - 1e-12).all()
        assert better.max() > simple.max() > 0.0


def test_maps_of_other_vessels() -> None:
    thrusters = VESSEL.model_dump()["thrusters"]
    two = map_cases(with_thrusters(thrusters[2:]))
    assert {case.axes for case in two} == {(0, 1)}
    assert {case.held for case in two} == {None}
    five = with_thrusters([*thrusters, thrusters[1] | {"name": "azimuth_mid", "position": (0.0, 0.1, 0.0)}])
    for case in map_cases(five):
        assert work_out(five, case, points=5).gain.shape == (5, 5)


def test_a_map_needs_two_directions() -> None:
    with pytest.raises(InputError, match="map: expected at least two azimuth thrusters to turn, found 1 on cyber"):
        map_cases(with_thrusters(VESSEL.model_dump()["thrusters"][:2]))


def test_loss_of_a_bus_of_the_vessel_file() -> None:
    losses = bus_losses(VESSEL, FREE)
    assert [(loss.bus, loss.left.thrusters) for loss in losses if loss.left] == [("bus_a", (1, 3)), ("bus_b", (0, 2))]
    document = VESSEL.model_dump()
    document["power"] = {"buses": [{"name": "all", "thrusters": list(VESSEL.thruster_names)}]}
    (loss,) = bus_losses(Vessel.model_validate(document), FREE)
    assert loss.left is None
    assert bus_losses(with_thrusters(document["thrusters"]), FREE) == ()
