"""Runs F to I of the thesis, sailed in process: what the scenarios claim holds."""

from __future__ import annotations

import pytest

from dp_tools.faults import faults
from dp_tools.figures import Figure, compute_figures
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import load_scenario
from marine_model import load_vessel
from support.repository import SCENARIOS

VESSEL = load_vessel("cybership3")


def sailed(name: str) -> dict[str, Figure]:
    scenario = load_scenario(SCENARIOS / f"{name}.yaml")
    run = ClosedLoop(VESSEL, scenario).run()
    return {figure.spec.name: figure for figure in compute_figures(run, scenario, VESSEL)}


@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", ["run_f", "run_g", "run_h", "run_i"])
def test_claims_hold(name: str) -> None:
    figures = sailed(name)
    assert {key for key, figure in figures.items() if figure.held is False} == set()
    assert sum(figure.held is True for figure in figures.values()) >= 6
    # What has no bound has been measured all the same.
    assert {key for key, figure in figures.items() if figure.value is None} == set()


@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("run_h", ["234", "134", "124", "123", "34", "24", "14", "12"]),
        (
            "run_i",
            ["azimuth 2", "azimuth 3", "azimuth 4", "azimuth 2 3", "azimuth 2 4", "azimuth 3 4"],
        ),
    ],
)
def test_failures_come_one_after_another_and_are_told_a_second_later(name: str, order: list[str]) -> None:
    scenario = load_scenario(SCENARIOS / f"{name}.yaml")
    found = faults(scenario, VESSEL)
    assert [fault.name for fault in found] == order
    told = {
        event.at: (values.get("thruster_enabled"), values.get("azimuth_enabled"))
        for event in scenario.events
        if (values := event.parameters.get("thrust_allocator", {}))
    }
    for fault in found:
        works = [[not failed for failed in parts] for parts in (fault.motors, fault.azimuths)]
        all_work = [True] * 4
        expected = (works[0], None) if any(fault.motors) else (None, works[1])
        assert told[fault.start + 1.0] == expected  # [Ruth] 6.5.3: five samples of 0.2 s
        assert told[fault.end] == ((all_work, None) if any(fault.motors) else (None, all_work))
