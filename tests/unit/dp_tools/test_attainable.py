"""Demands beside the minimum gain, on signals worked out by hand."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from dp_tools.attainable import attainable
from dp_tools.figures import compute_figures
from dp_tools.run_data import RunData, RunInfo, Series
from dp_tools.scenario import Scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.singularity import minimum_gain, scaled_configuration, scaling_of

SAMPLE = 0.2


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


def run_of(vessel: Vessel, surge: list[float], met: list[float], gain: float = 0.5) -> RunData:
    """Return a run with a scaled surge demand, of which ``met`` is commanded by the aft thrusters, pointing ahead."""
    scale = scaling_of(vessel).mean_thrust_max
    t = np.arange(len(surge)) * SAMPLE
    desired, achieved, thrust = np.zeros((len(t), 3)), np.zeros((len(t), 3)), np.zeros((len(t), 4))
    desired[:, 0], achieved[:, 0] = scale * np.array(surge), scale * np.array(met)
    thrust[:, 2] = thrust[:, 3] = 0.5 * achieved[:, 0]
    ahead = np.tile([math.pi / 2.0, 0.0, 0.0, 0.0], (len(t), 1))
    gains = np.full((len(t), 1), gain)
    series = {
        "tau_desired": Series(t, desired),
        "tau_achieved": Series(t, achieved),
        "thrust_command": Series(t, thrust),
        "azimuth_command": Series(t, ahead),
        "minimum_gain_both_ways": Series(t, gains),
        "minimum_gain": Series(t, 0.5 * gains),
    }
    return RunData(RunInfo("trial", vessel.name, "made up"), vessel.thruster_names, series)


def measured(run: RunData, vessel: Vessel, *specs: dict[str, Any]) -> list[float | None]:
    trial = Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": vessel.name,
            "duration": 100.0,
            "windows": {"all": [0.0, 100.0]},
            "figures": [{"name": f"f{i}", "title": "F", "window": "all"} | spec for i, spec in enumerate(specs)],
        }
    )
    return [figure.value for figure in compute_figures(run, trial, vessel)]


def test_samples_are_inside_too_fast_or_beyond(vessel: Vessel) -> None:
    # sigma_min 0.5, so thrusts at 0.2 T_max a sample follow a change of 0.1, (7.15).
    #       inside, met | beyond, met | beyond, missed | falls by 0.3: too fast, missed | inside, missed | inside
    surge = [0.05, 0.14, 0.23, 0.32, 0.41, 0.51, 0.60, 0.20, 0.35, 0.35]
    met = [0.05, 0.14, 0.23, 0.32, 0.41, 0.51, 0.50, 0.32, 0.33, 0.35]
    run = run_of(vessel, surge, met)
    found = attainable(run, vessel)
    assert found.demand == pytest.approx(surge)
    assert found.commanded == pytest.approx(met)
    assert found.missed == pytest.approx(np.abs(np.subtract(surge, met)), abs=1e-12)
    assert found.change == pytest.approx(np.abs(np.subtract(surge, [0.0, *met[:-1]])), abs=1e-12)
    assert found.change_allowed == pytest.approx(0.2 * 0.5)
    kinds = [{"kind": "attainable_samples", "demand": demand} for demand in ("inside", "too_fast", "beyond")]
    assert measured(run, vessel, *kinds) == [7.0, 1.0, 2.0]
    assert measured(run, vessel, *({**kind, "missed": True} for kind in kinds)) == [1.0, 1.0, 1.0]
    # 0.02 was missed in the sample inside.
    assert measured(run, vessel, {**kinds[0], "missed": True, "tolerance": 0.03}) == [0.0]


def test_the_change_is_that_along_the_directions_of_the_sample(vessel: Vessel) -> None:
    """Thrust that stays while the thrusters turn away is force that has gone."""
    run = run_of(vessel, [0.05, 0.05], [0.05, 0.05])
    turned = run["azimuth_command"].values.copy()
    turned[1, 2:] = math.pi
    series = {**run.series, "azimuth_command": Series(run["tau_desired"].t, turned)}
    assert attainable(dataclasses.replace(run, series=series), vessel).change == pytest.approx([0.05, 0.10])


def test_gains_by_how_hard_thrusters_push_astern(vessel: Vessel) -> None:
    run = run_of(vessel, [0.1], [0.1])
    assert attainable(run, vessel, "as_ahead").gain == pytest.approx([0.5])
    assert attainable(run, vessel, "none").gain == pytest.approx([0.25])
    angles = run["azimuth_command"].values[0]
    weaker = np.minimum(vessel.thrust_max, -vessel.thrust_min) / vessel.thrust_max
    expected = minimum_gain(scaled_configuration(vessel, angles) * weaker).gain
    assert attainable(run, vessel, "own").gain == pytest.approx([expected])


def test_gain_of_run_j() -> None:
    """What the fixed directions of [Ruth] 7.9.1 give, with either set of lever arms and with reverse as it is."""
    angles = np.radians([90.0, 80.0, 26.0, 46.0])
    for name, expected in (("cybership3", 0.535), ("cybership3_ch7", 0.570)):
        assert minimum_gain(scaled_configuration(load_vessel(name), angles)).gain == pytest.approx(expected, abs=5e-4)


def test_without_watched_gains_it_says_so(vessel: Vessel) -> None:
    run = run_of(vessel, [0.1], [0.1])
    series = {name: entry for name, entry in run.series.items() if not name.startswith("minimum_gain")}
    with pytest.raises(InputError, match="found 'minimum_gain_both_ways'"):
        attainable(dataclasses.replace(run, series=series), vessel)


def with_gains(run: RunData, gains: list[float], port: FloatArray) -> RunData:
    t = np.arange(len(gains)) * SAMPLE
    azimuth = np.zeros((len(t), 4))
    azimuth[:, 2] = port
    series = {
        "minimum_gain_both_ways": Series(t, np.array(gains)[:, None]),
        "azimuth_command": Series(t, azimuth),
    }
    return dataclasses.replace(run, series=series)


def test_levels_and_low_gains(vessel: Vessel) -> None:
    # Five times over: an interval of a mean needs 20 samples.
    run = with_gains(
        run_of(vessel, [0.0], [0.0]), 5 * [0.6, 0.4, 0.3, 0.3, 0.5, 0.2], np.tile([0.0, 0.1, 0.2, 0.2, 0.3, 0.3], 5)
    )
    level = {"kind": "gain_level"}
    low = {"kind": "low_gain_samples", "limit": 0.5}
    assert measured(run, vessel, {**level, "statistic": "min"}, {**level, "statistic": "mean"}) == [
        0.2,
        pytest.approx(2.3 / 6.0),
    ]
    # Of six samples four are below 0.5; the fourth and the last of them stand still.
    assert measured(run, vessel, low, {**low, "at_rest": True}) == [20.0, 10.0]


def test_lag_of_a_thruster_behind_its_command(vessel: Vessel) -> None:
    """A direction that sweeps through 180 deg, and a thrust, each measured three steps late."""
    fine = 0.02
    tf = np.arange(2000) * fine
    t = tf[::10]
    turning = np.zeros((len(t), 4))
    turning[:, 2] = np.arctan2(np.sin(0.3 * t + 3.0), np.cos(0.3 * t + 3.0))
    thrust = np.zeros((len(t), 4))
    thrust[:, 2] = 4.0 + 2.0 * np.sin(0.5 * t)
    late = np.searchsorted(t, tf - 3 * fine + 5e-7, side="right") - 1
    late = np.maximum(late, 0)
    series = {
        "azimuth_command": Series(t, turning),
        "azimuth": Series(tf, turning[late]),
        "thrust_command": Series(t, thrust),
        "shaft_speed": Series(tf, vessel.propellers.shaft_speed(thrust[late])),
    }
    run = dataclasses.replace(run_of(vessel, [0.0], [0.0]), series=series)
    lag = {"kind": "actuator_lag", "thruster": "azimuth_port"}
    assert measured(run, vessel, {**lag, "of": "azimuth"}, {**lag, "of": "thrust"}) == pytest.approx([0.06, 0.06])


def test_share_of_the_time_in_which_force_is_met(vessel: Vessel) -> None:
    run = run_of(vessel, 5 * [0.1, 0.2, 0.3, 0.4], 5 * [0.1, 0.21, 0.25, 0.4])  # 0.09 N and 0.45 N off
    met = {"kind": "force_met", "tolerance": [0.1, 0.1, 0.1]}
    assert measured(run, vessel, met, {**met, "tolerance": [0.05, 0.1, 0.1]}) == [0.75, 0.5]
