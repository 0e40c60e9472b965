"""The scenario in wind and current: feed-forward holds the position better, and comes without a bump."""

from __future__ import annotations

import numpy as np
import pytest

from dp_tools.in_process import ClosedLoop
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.signals import position_error
from marine_model import load_vessel
from marine_model.errors import InputError
from support.repository import SCENARIOS

VESSEL = load_vessel("cybership3")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario(SCENARIOS / "wind_and_current.yaml")


@pytest.fixture(scope="module")
def run(scenario: Scenario) -> RunData:
    return ClosedLoop(VESSEL, scenario).run()


def test_position_error_falls_in_every_axis(run: RunData, scenario: Scenario) -> None:
    error = position_error(run, "truth_position")
    without, with_ = (error.window(*scenario.windows[name]).values.std(axis=0) for name in ("without", "with"))
    # Over five seeds it falls to 0.63 - 0.86 north, 0.58 - 0.63 east, 0.62 - 0.67 in heading.
    assert (with_ / without < [0.95, 0.75, 0.75]).all()


def test_switching_it_on_moves_the_demand_no_more_than_gusts_do(run: RunData, scenario: Scenario) -> None:
    demand = run["tau_desired"]
    steps = np.abs(np.diff(demand.window(*scenario.windows["without"]).values, axis=0)).max(axis=0)
    terms = run["wind_feedforward"].values
    first = int(np.flatnonzero(terms.any(axis=1))[0])
    assert demand.t[first] == pytest.approx(541.0)  # a filter time after it was enabled
    assert (np.abs(demand.values[first] - demand.values[first - 1]) < steps).all()
    # What changes hands is larger: more than twice in surge, five times in sway and yaw.
    assert (np.abs(terms[first]) > [2.0, 5.0, 5.0] * steps).all()


def test_the_integral_is_left_with_what_the_wind_does_not_explain(run: RunData, scenario: Scenario) -> None:
    integral, feedforward = (
        run[name].window(*scenario.windows["with"]).values.mean(axis=0) for name in ("integral", "wind_feedforward")
    )
    before = run["integral"].window(*scenario.windows["without"]).values.mean(axis=0)
    # Both windows are 480 s of one wind and one current; means of gusts over them differ by some per cent.
    np.testing.assert_allclose(integral + feedforward, before, atol=0.15 * np.abs(feedforward).max())


def test_nothing_else_was_amiss(run: RunData) -> None:
    assert run.labels["controller_status"].words == ("nominal",)
    assert run.labels["allocation_status"].words == ("optimal",)
    assert "wind" in run
    assert not run["wind_feedforward"].window(0.0, 540.0).values.any()


def test_a_vessel_without_wind_forces_does_not_sail_it(scenario: Scenario) -> None:
    bare = VESSEL.model_copy(update={"wind_forces": None})
    with pytest.raises(InputError, match=r"wind\.speed: expected 0, because vessel 'cybership3' has no section"):
        ClosedLoop(bare, scenario)
