"""All thrusters together: limits, stale commands, lost sensors."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thruster_drivers import DriverInputs, Drivers, DriverSettings

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
TIMEOUT = VESSEL.drivers.command_timeout
RATE = VESSEL.thrust_rate
THRUST = np.array([0.4, 6.0, -8.0, 12.0])
AZIMUTH = np.array([math.pi / 2, 1.0, -2.0, 3.0])
REST = np.zeros(4)
STEPS_TO_FULL = round(1.0 / DT)  # the vessel's thrust rate is T_max a second


def inputs(
    thrust: FloatArray = THRUST,
    azimuth: FloatArray = AZIMUTH,
    age: float = 0.0,
    shaft_speed: FloatArray = REST,
    measured_azimuth: FloatArray = AZIMUTH,
) -> DriverInputs:
    return DriverInputs(thrust, azimuth, age, shaft_speed, REST, measured_azimuth)


def test_the_command_is_reached_at_the_thrust_rate_and_held() -> None:
    drivers = Drivers(VESSEL)
    for k in range(1, STEPS_TO_FULL + 5):
        output = drivers.step(inputs(), DT)
        expected = np.sign(THRUST) * np.minimum(np.abs(THRUST), k * RATE * DT)
        np.testing.assert_allclose(output.thrust_reference, expected, atol=1e-12)  # rounding of k additions
        np.testing.assert_allclose(output.shaft_speed_reference, VESSEL.propellers.shaft_speed(expected), rtol=1e-9)
    assert output.status == "nominal"
    assert not output.command_stale
    np.testing.assert_array_equal(output.thrust_reference, THRUST)


def test_before_the_first_command_nothing_moves() -> None:
    drivers = Drivers(VESSEL)
    nothing = np.full(4, math.nan)  # not looked at
    for _ in range(10):
        output = drivers.step(inputs(nothing, nothing, math.inf), DT)
        for array in (output.torque, output.azimuth_rate, output.shaft_speed_reference, output.thrust_reference):
            np.testing.assert_array_equal(array, REST)
        assert output.command_stale
        assert output.status == "no_command"


def test_stale_command_ramps_to_zero_holds_the_azimuth_and_recovers() -> None:
    drivers = Drivers(VESSEL)
    for _ in range(STEPS_TO_FULL):
        drivers.step(inputs(age=TIMEOUT), DT)  # at the limit: still fresh
    measured = AZIMUTH - 0.5
    for k in range(1, STEPS_TO_FULL + 1):
        output = drivers.step(inputs(age=TIMEOUT + k * DT, measured_azimuth=measured), DT)
        expected = np.sign(THRUST) * np.maximum(np.abs(THRUST) - k * RATE * DT, 0.0)
        np.testing.assert_allclose(output.thrust_reference, expected, atol=1e-12)  # rounding
        assert output.command_stale
        assert output.status == "command_stale"
        np.testing.assert_array_equal(output.azimuth_rate, REST)
    np.testing.assert_array_equal(output.thrust_reference, REST)

    output = drivers.step(inputs(measured_azimuth=measured), DT)
    assert not output.command_stale
    assert output.status == "nominal"
    np.testing.assert_allclose(output.thrust_reference, np.sign(THRUST) * RATE * DT)
    assert output.azimuth_rate[0] == 0.0
    assert np.all(output.azimuth_rate[1:] > 0.0)


def test_recovery_in_mid_ramp_goes_on_from_where_the_thrust_is() -> None:
    drivers = Drivers(VESSEL)
    for _ in range(STEPS_TO_FULL):
        drivers.step(inputs(), DT)
    for _ in range(5):
        low = drivers.step(inputs(age=2.0 * TIMEOUT), DT).thrust_reference
    np.testing.assert_allclose(np.abs(THRUST - low), 5 * RATE * DT)
    for _ in range(5):
        back = drivers.step(inputs(), DT).thrust_reference
    np.testing.assert_allclose(back, THRUST)


@given(
    st.lists(
        st.tuples(
            st.lists(st.floats(-1e3, 1e3), min_size=4, max_size=4),
            st.sampled_from([0.0, 0.3, TIMEOUT, TIMEOUT + 0.01, 100.0, math.inf, -0.1, -100.0]),
            st.sampled_from([0.001, 0.02, 0.2, 3.0]),
            st.sampled_from([0.0, 30.0, -1e6, math.nan]),
        ),
        min_size=1,
        max_size=20,
    )
)
def test_no_history_moves_thrust_faster_than_its_rate_or_beyond_a_limit(
    history: list[tuple[list[float], float, float, float]],
) -> None:
    drivers = Drivers(VESSEL)
    first = history[0][3]
    start = VESSEL.propellers.thrust(np.full(4, 0.0 if math.isnan(first) else first))
    last = start.clip(VESSEL.thrust_min, VESSEL.thrust_max)
    for thrust, age, dt, speed in history:
        output = drivers.step(inputs(np.array(thrust), AZIMUTH + 2.0, age, np.full(4, speed)), dt)
        moved = np.abs(output.thrust_reference - last)
        assert np.all(moved <= RATE * dt * (1.0 + 1e-12) + 1e-12)  # rounding
        last = output.thrust_reference
        assert np.all(last >= VESSEL.thrust_min)
        assert np.all(last <= VESSEL.thrust_max)
        torque_max = np.array([t.shaft.torque_max for t in VESSEL.thrusters])
        assert np.all(np.abs(output.torque) <= torque_max)
        assert np.all(np.abs(output.azimuth_rate) <= VESSEL.azimuth_rate)
        assert output.command_stale == (abs(age) > TIMEOUT)


def test_a_driver_that_starts_under_way_ramps_from_the_thrust_it_finds() -> None:
    found = np.array([0.2, 3.0, -4.0, 5.0])
    output = Drivers(VESSEL).step(inputs(age=math.inf, shaft_speed=VESSEL.propellers.shaft_speed(found)), DT)
    np.testing.assert_allclose(output.thrust_reference, found - np.sign(found) * RATE * DT)


def test_a_command_from_the_future_is_stale() -> None:
    output = Drivers(VESSEL).step(inputs(age=-1.5 * TIMEOUT), DT)
    assert output.status == "command_stale"


def test_timeout_of_the_settings_wins_and_is_swapped_live() -> None:
    drivers = Drivers(VESSEL, DriverSettings(command_timeout=0.1))
    assert drivers.step(inputs(age=0.2), DT).command_stale
    drivers.apply(DriverSettings())
    assert not drivers.step(inputs(age=0.2), DT).command_stale


def test_applying_settings_keeps_thrust_and_integral() -> None:
    drivers, untouched = Drivers(VESSEL), Drivers(VESSEL)
    for _ in range(10):
        drivers.step(inputs(), DT)
        untouched.step(inputs(), DT)
    drivers.apply(DriverSettings(command_timeout=2.0))
    np.testing.assert_array_equal(drivers.step(inputs(), DT).torque, untouched.step(inputs(), DT).torque)


def test_a_lost_shaft_speed_leaves_the_other_thrusters_alone() -> None:
    whole, lost = Drivers(VESSEL), Drivers(VESSEL)
    speed = np.array([5.0, 4.0, 3.0, 2.0])
    broken = speed.copy()
    broken[1] = math.nan
    expected = whole.step(inputs(shaft_speed=speed), DT)
    output = lost.step(inputs(shaft_speed=speed), DT)
    for _ in range(5):
        expected = whole.step(inputs(shaft_speed=speed), DT)
        output = lost.step(inputs(shaft_speed=broken), DT)
    assert output.status == "sensor_lost"
    others = [0, 2, 3]
    np.testing.assert_array_equal(output.torque[others], expected.torque[others])
    assert np.isfinite(output.torque[1])
    assert lost.step(inputs(shaft_speed=speed), DT).status == "nominal"


def test_a_lost_azimuth_stops_that_motor_and_matters_only_where_there_is_one() -> None:
    measured = AZIMUTH - 0.3
    measured[2] = math.nan
    output = Drivers(VESSEL).step(inputs(measured_azimuth=measured), DT)
    assert output.status == "sensor_lost"
    assert output.azimuth_rate[2] == 0.0
    assert output.azimuth_rate[1] > 0.0
    assert output.azimuth_rate[3] > 0.0
    measured = AZIMUTH.copy()
    measured[0] = math.nan  # a tunnel thruster
    assert Drivers(VESSEL).step(inputs(measured_azimuth=measured), DT).status == "nominal"


@pytest.mark.parametrize(
    ("change", "dt", "message"),
    [
        ({"thrust_command": np.array([0.0, math.nan, 0.0, 0.0])}, DT, "thrust_command: expected finite numbers"),
        ({"azimuth_command": np.array([0.0, 0.0, 0.0, math.inf])}, DT, "azimuth_command: expected finite numbers"),
        ({"thrust_command": np.zeros(3)}, DT, r"thrust_command: expected shape \(4,\), found \(3,\)"),
        ({"shaft_speed": np.zeros(5)}, DT, r"shaft_speed: expected shape \(4,\), found \(5,\)"),
        ({"azimuth": np.zeros((4, 1))}, DT, r"azimuth: expected shape \(4,\), found \(4, 1\)"),
        ({"thrust_command": np.zeros((4, 1))}, DT, r"thrust_command: expected shape \(4,\), found \(4, 1\)"),
        ({"command_age": math.nan}, DT, "command_age: expected a number, found nan"),
        ({}, 0.0, "dt: expected a number above 0"),
        ({}, -DT, "dt: expected a number above 0"),
        ({}, math.nan, "dt: expected a finite number"),
    ],
)
def test_bad_input_is_refused_and_nothing_is_lost(change: dict[str, Any], dt: float, message: str) -> None:
    drivers, untouched = Drivers(VESSEL), Drivers(VESSEL)
    for _ in range(5):
        drivers.step(inputs(), DT)
        untouched.step(inputs(), DT)
    with pytest.raises(InputError, match=message):
        drivers.step(replace(inputs(), **change), dt)
    after, expected = drivers.step(inputs(), DT), untouched.step(inputs(), DT)
    np.testing.assert_array_equal(after.torque, expected.torque)
    np.testing.assert_array_equal(after.thrust_reference, expected.thrust_reference)


@pytest.mark.parametrize("bad", [{"controller": "magic"}, {"command_timeout": -1.0}, {"command_timeout": math.nan}])
def test_bad_settings_are_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=next(iter(bad))):
        DriverSettings(**bad)
