"""Pose faults in the loop in process: bounds on what they may do to the vessel, and what has to be shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dp_tools.disturber.campaign import FAULTS, FaultFigures, PoseFault, judge, sail, voyage
from dp_tools.disturber.loop import DisturbedLoop, Witness
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel

BY_NAME = {fault.name: fault for fault in FAULTS}


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return voyage(load_scenario("run_a"))


@pytest.fixture(scope="module")
def undisturbed(vessel: Vessel, scenario: Scenario) -> Witness:
    return sail(vessel, scenario, None)


def test_without_a_fault_it_is_the_loop_to_the_bit(vessel: Vessel, scenario: Scenario) -> None:
    short = scenario.model_copy(update={"duration": 30.0})
    plain, loop = ClosedLoop(vessel, short).run(), DisturbedLoop(vessel, short, []).run()
    for name, series in plain.series.items():
        assert np.array_equal(series.values, loop.series[name].values, equal_nan=True), name


@pytest.mark.parametrize(
    ("name", "largest", "shown"),
    [
        # A tenth of a millimetre to a millimetre was measured; 0.02 m is a hundredth of the hull.
        ("lose 10 %", 0.02, "OBSERVER-MEASUREMENTS-LOST"),
        ("lose 50 %", 0.02, "OBSERVER-MEASUREMENTS-LOST"),
        ("delay 0.6 s", 0.02, "OBSERVER-MEASUREMENTS-LOST"),
        ("reorder 30 %", 0.02, "NODE-INPUT-REFUSED"),
        ("jump 10 m for 0.4 s", 0.02, "OBSERVER-FIX-REFUSED"),
        ("NaN 10 %", 0.02, "NODE-INPUT-REFUSED"),
        ("heading plus one turn", 1e-6, ""),
        ("quaternion of the other sign", 1e-6, ""),
        # Twice what was measured: 0.2 m.
        ("NaN for 20 s", 0.4, "OBSERVER-ESTIMATE-INVALID"),
        ("lose all for 20 s", 0.4, "OBSERVER-ESTIMATE-INVALID"),
    ],
)
def test_a_fault_is_shown_and_stays_within_bounds(
    vessel: Vessel, scenario: Scenario, undisturbed: Witness, name: str, largest: float, shown: str
) -> None:
    found = judge(BY_NAME[name], sail(vessel, scenario, BY_NAME[name]), undisturbed)
    assert found.largest < largest
    assert found.recovery is not None
    assert found.recovery < 20.0
    assert (shown in found.shown) if shown else not found.shown


def test_figures_are_those_of_the_difference() -> None:
    time = [59.8, 60.0, 70.0, 80.0, 90.0, 100.0]
    zero = [np.zeros(3) for _ in time]
    off = [np.array([x, 0.0, turn]) for x, turn in ((9.0, 0), (0.0, 0), (0.6, 0.1), (0.8, 0), (0.2, 0), (0.01, 0))]
    found = judge(
        PoseFault("made up", {}),
        Witness(time, off, {"OLD": 3.0, "BOTH": 62.0, "NEW": 61.0}, 7),
        Witness(time, zero, {"BOTH": 1.0}),
    )
    expected = FaultFigures("made up", 0.8, 0.1, 0.3 * 2**0.5, 10.0, ("NEW",), 1.0, 7)
    assert replace(found, rms=expected.rms, heading=expected.heading) == expected
    assert found.rms == pytest.approx(expected.rms)
    assert found.heading == pytest.approx(expected.heading)
