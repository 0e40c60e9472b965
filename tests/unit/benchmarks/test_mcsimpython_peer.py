"""The peer does what it is timed for: in the waves of Run A it drifts, or keeps station. Only where it is installed."""

import math

import pytest

from benchmarks.mcsimpython_peer import StationKeeping, VesselInWaves
from dp_tools.scenario import load_scenario
from marine_model import load_vessel

pytest.importorskip("MCSimPython", reason="an optional package of the benchmarks")


def test_adrift_it_is_carried_off_and_its_control_holds_it() -> None:
    scenario = load_scenario("run_a")
    vessel = load_vessel(scenario.vessel)
    adrift, held = (kind(vessel, scenario.settings(vessel)) for kind in (VesselInWaves, StationKeeping))
    for ship in (adrift, held):
        ship.sail(60.0)
    # Head seas push astern, all the time; the held one gives way at first and stays within a ship's length of 2.6 m.
    assert adrift.position[0] < -1.0
    assert math.hypot(held.position[0], held.position[1]) < 0.5
