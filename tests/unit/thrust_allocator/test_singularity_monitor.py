"""The live monitor gives what the functions it stands for give."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from thrust_allocator.singularity import (
    Watch,
    classify,
    horizon_window,
    local_minimum_gain,
    minimum_gain,
    monitor,
    project,
    scaled_configuration,
    scaling_of,
    window_minimum_gain,
)

VESSEL = load_vessel("cybership3")
SCALING = scaling_of(VESSEL)
ROTATES = np.array([False, True, True, True])
ALL = np.ones(4, dtype=bool)


def operating_point(**changes: Any) -> dict[str, Any]:
    point: dict[str, Any] = {
        "scaling": SCALING,
        "thrust": np.array([0.1, 3.0, 4.0, 5.0]),
        "azimuth": np.array([math.pi / 2, 0.6, 2.5, -0.8]),
        "enabled": ALL,
        "thrust_min": VESSEL.thrust_min,
        "thrust_max": VESSEL.thrust_max,
        "may_rotate": ROTATES,
        "azimuth_rate": np.array([0.0, 1.05, 1.05, 1.05]),
        "horizon": 1.0,
        "delta_minus": -0.1 * VESSEL.thrust_max,
        "delta_plus": 0.1 * VESSEL.thrust_max,
    }
    return {**point, **changes}


fractions = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4).map(np.array)
angles = st.lists(st.floats(-math.pi, math.pi), min_size=4, max_size=4).map(np.array)
masks = st.lists(st.booleans(), min_size=4, max_size=4).map(np.array)


@given(fractions, angles, masks, masks, st.sampled_from(["auto", "theorem_7_1", "theorem_7_2", "exact"]))
def test_monitor_equals_the_single_functions(
    level: np.ndarray, azimuth: np.ndarray, enabled: np.ndarray, rotating: np.ndarray, method: str
) -> None:
    azimuth[0] = VESSEL.fixed_direction[0]
    rotating[0] = False
    limits = np.array([1.0, 0.5, 1.0, 1.0])  # thruster 2 is limited to half its thrust
    low, high = limits * VESSEL.thrust_min, limits * VESSEL.thrust_max
    thrust = level * high
    point = operating_point(
        thrust=thrust,
        azimuth=azimuth,
        enabled=enabled,
        may_rotate=rotating,
        thrust_min=low,
        thrust_max=high,
        method=method,
    )
    reading = monitor(**point)
    limited = replace(SCALING, thrust_max=high)
    B = scaled_configuration(limited, azimuth, enabled)
    expected = minimum_gain(B, rotating[enabled], method)  # type: ignore[arg-type]
    close = {"rel": 1e-9, "abs": 1e-9}
    assert reading.global_gain == pytest.approx(expected.gain, **close)
    kinds = classify(thrust, np.where(rotating, 0.0, low), high, point["delta_minus"], point["delta_plus"])
    local = local_minimum_gain(B, kinds[enabled], method)  # type: ignore[arg-type]
    assert reading.local_gain == pytest.approx(local.gain, **close)
    start, end = horizon_window(azimuth, np.where(rotating, point["azimuth_rate"], 0.0), 1.0)
    ahead = window_minimum_gain(limited, start, end, enabled, rotating, method)  # type: ignore[arg-type]
    assert reading.horizon_gain == pytest.approx(ahead.gain, **close)
    arrow = project(reading.direction)
    assert reading.projection_length == pytest.approx(arrow.length, abs=1e-12)
    assert reading.projection_angle == pytest.approx(arrow.angle, abs=1e-12)


def test_a_horizon_does_not_lower_the_exact_gain() -> None:
    reading = monitor(**operating_point(method="exact"))
    assert reading.horizon_gain > reading.global_gain


def test_turns_end_where_they_may() -> None:
    held = monitor(**operating_point(turn_low=np.zeros(4), turn_high=np.zeros(4)))
    assert held.horizon_gain == held.global_gain
    free = monitor(**operating_point(turn_low=np.full(4, -2.0), turn_high=np.full(4, 2.0)))
    assert free.horizon_gain == monitor(**operating_point()).horizon_gain
    part = monitor(**operating_point(turn_low=np.full(4, -0.2), turn_high=np.full(4, 0.3), method="exact"))
    assert held.global_gain <= part.horizon_gain <= monitor(**operating_point(method="exact")).horizon_gain


@pytest.mark.parametrize("watch", list(Watch))
def test_only_what_is_watched_is_computed(watch: Watch) -> None:
    everything, reading = monitor(**operating_point()), monitor(**operating_point(watch=watch))
    for flag, field in (
        (Watch.GLOBAL, "global_gain"),
        (Watch.LOCAL, "local_gain"),
        (Watch.HORIZON, "horizon_gain"),
        (Watch.GLOBAL, "projection_angle"),
        (Watch.GLOBAL, "projection_length"),
    ):
        value = getattr(reading, field)
        assert value == getattr(everything, field) if watch == flag else math.isnan(value)
    assert np.isnan(reading.direction).all() == (watch != Watch.GLOBAL)


def test_all_thrusters_lost() -> None:
    reading = monitor(**operating_point(enabled=np.zeros(4, dtype=bool)))
    assert reading[:3] == (0.0, 0.0, 0.0)


def test_inputs_are_left_alone() -> None:
    point = operating_point()
    before = {name: np.copy(value) for name, value in point.items() if isinstance(value, np.ndarray)}
    monitor(**point)
    for name, value in before.items():
        np.testing.assert_array_equal(point[name], value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"thrust": np.zeros(3)}, r"thrust: expected shape \(4,\), found \(3,\)"),
        ({"azimuth": np.array([0.0, np.nan, 0.0, 0.0])}, "azimuth: expected finite"),
        ({"enabled": np.ones(4)}, "enabled: expected 4 bools"),
        ({"may_rotate": np.ones(3, dtype=bool)}, "may_rotate: expected 4 bools"),
        ({"horizon": -1.0}, "horizon -1.0"),
        ({"horizon": math.inf}, "horizon: expected a finite number"),
        ({"delta_minus": np.ones(4)}, "thrust_min, delta_minus, turn_low: expected numbers not above 0"),
        ({"turn_high": -np.ones(4)}, "turn_high, horizon: expected numbers not below 0"),
        ({"method": "svd"}, "method: expected one of auto, theorem_7_1, theorem_7_2, lemma_7_1, exact, found 'svd'"),
    ],
)
def test_bad_input_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        monitor(**operating_point(**change))


def test_lists_are_numbers_too() -> None:
    point = operating_point()
    assert monitor(**{**point, "thrust": point["thrust"].tolist()})[:3] == monitor(**point)[:3]
