"""Figures of sectors, of auto mode, of deviations and excursions, on signals worked out by hand."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from dp_tools.faults import faults
from dp_tools.figures import compute_figures
from dp_tools.run_data import Labels, RunData, Series
from dp_tools.scenario import Scenario
from marine_model import Vessel, load_vessel
from support.synthetic_run import SAMPLE, synthetic_run

VESSEL = load_vessel("cybership3")
PORT = 2  # azimuth_port: forbidden from -110 to -70 deg and from 159 to 210 deg
RATE = float(VESSEL.azimuth_rate[PORT])  # rad/s


def with_series(run: RunData, **series: Series) -> RunData:
    return dataclasses.replace(run, series={**run.series, **series})


def measured(run: RunData, vessel: Vessel = VESSEL, **spec: Any) -> float | None:
    scenario = Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": "cybership3",
            "duration": 40.0,
            "windows": {"w": [0.0, 40.0], "late": [20.0, 40.0], "middle": [10.0, 20.0]},
            "figures": [{"name": "one", "title": "One"} | spec],
        }
    )
    (figure,) = compute_figures(run, scenario, vessel)
    return figure.value


@pytest.fixture(scope="module")
def run() -> RunData:
    return synthetic_run(VESSEL, 40.0)


def turning(run: RunData, degrees: list[float], name: str = "azimuth_command") -> RunData:
    """The port thruster points so in the first samples, then as at the last of them; the others at 45 and -45 deg."""
    t = run["azimuth_command"].t
    values = np.zeros((len(t), 4)) + np.radians([90.0, 90.0, 45.0, -45.0])
    angles = np.concatenate([degrees, np.full(len(t) - len(degrees), degrees[-1])])
    values[:, PORT] = (np.radians(angles) + math.pi) % (2.0 * math.pi) - math.pi
    return with_series(run, **{name: Series(t, values)})


FULL = math.degrees(RATE * SAMPLE)  # 12.03 deg a sample


@pytest.mark.parametrize(
    ("angles", "dwell"),
    [
        ([-60.0, -70.0, -70.0 - FULL, -70.0 - 2 * FULL, -70.0 - 3 * FULL, -112.0], 0.0),  # three samples inside
        ([-110.0, -100.0, -100.0, -100.0, -115.0], 0.4),  # stands still for two samples
        ([-110.0, -90.0 - FULL / 2, -90.0, -70.0], 0.1),  # one step at half the rate
        ([-112.0, -110.0 + FULL, -110.0 + 2 * FULL, -110.0 + FULL, -112.0], 0.4),  # turns back: no way made good
        ([150.0, 159.0 + FULL, 159.0 + 2 * FULL, 159.0 + 3 * FULL, 215.0], 0.0),  # through 180 deg
        ([-110.0, -70.0], 0.0),  # from end to end
    ],
)
def test_dwelling_in_a_forbidden_sector(run: RunData, angles: list[float], dwell: float) -> None:
    found = measured(turning(run, angles), kind="forbidden_dwell", window="w")
    assert found == pytest.approx(dwell, abs=1e-9)
    assert measured(turning(run, angles, "azimuth"), kind="forbidden_dwell", window="w", of="measured") == found


def test_a_margin_leaves_out_who_rests_at_the_end_of_a_sector(run: RunData) -> None:
    resting = turning(run, [-108.0])
    assert measured(resting, kind="forbidden_dwell", window="w") == pytest.approx(39.8)
    assert measured(resting, kind="forbidden_dwell", window="w", margin=3.0) == 0.0


def crossing(run: RunData, flags: list[int]) -> RunData:
    t = run["azimuth_command"].t
    values = np.zeros((len(t), 4))
    values[: len(flags), PORT] = flags
    return with_series(run, crossing=Series(t, values))


def test_transits_at_full_rate_and_their_number(run: RunData) -> None:
    angles = [0.0, 0.0, FULL, 2 * FULL, 2 * FULL + 5.0, 2 * FULL + 5.0, 3 * FULL + 5.0, 3 * FULL + 8.0, 4 * FULL + 8.0]
    flags = [0, 0, 1, 1, 1, 0, 1, 1, 1]
    sailed = crossing(turning(run, angles), flags)
    # The third of the first transit arrives; the second of the second is slow and does not.
    assert measured(sailed, kind="transit_full_rate", window="w") == pytest.approx(5.0 / 6.0)
    assert measured(sailed, kind="switch_count", of="transit", window="w") == 2.0
    assert measured(crossing(run, []), kind="transit_full_rate", window="w") is None


def test_switches_are_counted_within_the_window(run: RunData) -> None:
    t = run["sub_problem"].t
    chosen = np.select([t < 5.0, t < 15.0, t < 15.2], [1.0, 4.0, 7.0], 1.0)[:, None]
    sailed = with_series(run, sub_problem=Series(t, chosen))
    assert measured(sailed, kind="switch_count", of="sub_problem", window="w") == 3.0
    assert measured(sailed, kind="switch_count", of="sub_problem", window="middle") == 2.0


def modes(run: RunData) -> RunData:
    labels = Labels(np.array([0.0, 12.4, 22.0, 31.6]), ("fixed", "rotating", "fixed", "rotating"))
    return dataclasses.replace(run, labels={**run.labels, "azimuth_mode": labels})


def test_auto_mode(run: RunData) -> None:
    sailed = modes(run)
    assert measured(sailed, kind="switch_count", of="azimuth_mode", window="w") == 3.0
    assert measured(sailed, kind="switch_count", of="azimuth_mode", window="late") == 2.0
    assert measured(sailed, kind="time_to_mode", mode="rotating", window="middle") == pytest.approx(2.4)
    assert measured(sailed, kind="time_to_mode", mode="fixed", window="middle") is None
    t = np.arange(50) * SAMPLE + 10.0
    sailed = with_series(run, performance_measure=Series(t, np.linspace(1.0, 2.0, 50)[:, None]))
    for statistic, expected in (("max", 2.0), ("min", 1.0), ("mean", 1.5)):
        found = measured(sailed, kind="performance_level", statistic=statistic, window="w")
        assert found == pytest.approx(expected)


def test_longest_deviation(run: RunData) -> None:
    t = run["tau_desired"].t
    desired = np.zeros((len(t), 3))
    achieved = desired.copy()
    achieved[10:14, 0] = 0.3  # 0.8 s in surge
    achieved[20:23, 2] = -0.2  # 0.6 s in yaw, and in sway before and after it
    achieved[19:25, 1] = 0.25
    achieved[40, 0] = 0.19
    sailed = with_series(run, tau_desired=Series(t, desired), tau_achieved=Series(t, achieved))
    spec: dict[str, Any] = {"kind": "deviation_time", "tolerance": [0.2, 0.2, 0.1]}
    assert measured(sailed, window="w", **spec) == pytest.approx(1.2)
    assert measured(sailed, window="late", **spec) == 0.0
    achieved[-3:, 0] = 1.0  # to the end, each sample held
    assert measured(sailed, window="late", **spec) == pytest.approx(0.6)


def test_largest_step_of_a_thrust(run: RunData) -> None:
    t = run["thrust_command"].t
    thrust = np.zeros((len(t), 4))
    thrust[50:, 1] = 0.5 * VESSEL.thrust_rate[1] * SAMPLE
    thrust[150:, 3] = -0.25 * VESSEL.thrust_rate[3] * SAMPLE
    sailed = with_series(run, thrust_command=Series(t, thrust))
    assert measured(sailed, kind="thrust_step", window="w") == pytest.approx(0.5)
    assert measured(sailed, kind="thrust_step", window="late") == pytest.approx(0.25)


def away(run: RunData, *parts: tuple[float, float, float]) -> RunData:
    """North (m), east (m) and heading error (deg) of every ten seconds in turn."""
    t = run["estimate_position"].t
    rows = np.minimum((t // 10.0).astype(int), len(parts) - 1)
    values = np.array(parts)[rows] * [1.0, 1.0, math.pi / 180.0]
    return with_series(run, estimate_position=Series(t, values))


def test_excursion_and_badness(run: RunData) -> None:
    sailed = away(run, (0.0, 0.0, 0.0), (0.3, -0.4, 4.0), (0.0, 0.0, 0.0), (0.0, 0.0, -30.0))
    length = VESSEL.hull.length
    scales: dict[str, Any] = {"lengths": 0.5, "heading": 20.0}
    assert measured(sailed, kind="excursion", window="middle", **scales) == pytest.approx(0.5 / (0.5 * length))
    assert measured(sailed, kind="excursion", window="w", **scales) == pytest.approx(1.5)
    expected = math.hypot(1.0 / length, 0.2)
    assert measured(sailed, kind="badness", window="middle", **scales) == pytest.approx(expected)
    # Half of the time at rest.
    assert measured(sailed, kind="badness", window="late", **scales) == pytest.approx(1.5 / math.sqrt(2.0))


def test_rank_agreement(run: RunData) -> None:
    sailed = away(run, (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.0))
    scales: dict[str, Any] = {"kind": "rank_agreement", "lengths": 0.5, "heading": 20.0}
    # RMS: w 0.56, middle 0.5, late 0.07.
    assert measured(sailed, worst_first=["w", "middle", "late"], **scales) == pytest.approx(1.0)
    assert measured(sailed, worst_first=["late", "middle", "w"], **scales) == pytest.approx(-1.0)
    # 1 - 6 * (1 + 1 + 0) / (3 * 8)
    assert measured(sailed, worst_first=["middle", "w", "late"], **scales) == pytest.approx(0.5)


def test_faults_of_a_scenario() -> None:
    scenario = Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": "cybership3",
            "duration": 40.0,
            "parameters": {"vessel_sim": {"propulsion.failed": [True, False, False, False]}},
            "events": [
                {"at": 5.0, "parameters": {"vessel_sim": {"waves.amplitude": 0.01}}},
                {"at": 10.0, "parameters": {"vessel_sim": {"propulsion.failed": [False, True, True, False]}}},
                {"at": 20.0, "parameters": {"vessel_sim": {"propulsion.failed": [False] * 4}}},
                {"at": 30.0, "parameters": {"vessel_sim": {"propulsion.azimuth_failed": [False, False, True, True]}}},
            ],
        }
    )
    found = [(fault.start, fault.end, fault.name, fault.thrusters) for fault in faults(scenario, VESSEL)]
    assert found == [
        (0.0, 10.0, "234", (True, False, False, False)),
        (10.0, 20.0, "14", (False, True, True, False)),
        (30.0, 40.0, "azimuth 3 4", (False, False, True, True)),
    ]
