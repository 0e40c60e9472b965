"""Detection on simulated ventilation, in a sea without any, and in reversals: what issue and docs promise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dp_tools.detection_campaign import (
    TORQUE_SLOPE,
    Record,
    Trial,
    campaign,
    moderate_sea_trial,
    sail,
    sensor_noise,
    tabulate,
    ventilation_trial,
)
from marine_model import load_vessel
from marine_model.errors import InputError
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from thruster_drivers.ventilation import VentilationSettings
from thruster_drivers.ventilation.loss_factor import least_speed

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
SAMPLE = VESSEL.measurement.sample_time
METHODS = ("torque_rate", "shaft_deceleration")


def settings(method: str, **changes: object) -> DriverSettings:
    return DriverSettings(ventilation=VentilationSettings.model_validate({"method": method, **changes}))


def test_every_event_is_found_within_two_samples() -> None:
    """(5.14)-(5.15) at 50 Hz, the default, on twenty minutes of ventilation of varied depth and speed."""
    record = sail(VESSEL, ventilation_trial(VESSEL, 1200.0, seed=11), settings("torque_rate"), seed=11)
    table = tabulate(VESSEL, record)
    assert table.events > 200  # of two thrusters
    assert (table.missed, table.found_in_time, table.false_alarms) == (0, table.events, 0)
    assert table.delays.max() <= 2.0 * SAMPLE + 1e-9  # rounding
    assert table.hours == pytest.approx(2.0 / 3.0)
    assert table.speeds.min() < 8.0
    assert table.speeds.max() > 18.0
    assert table.depths.min() < 0.1
    assert table.depths.max() > 0.4


def test_the_slow_form_finds_nearly_all() -> None:
    """(B.41)-(B.44) at 5 Hz: 98.7 % in time over 20 h; what is late is slow or begins in a rapid reduction."""
    record = sail(VESSEL, ventilation_trial(VESSEL, 1200.0, seed=11), settings("shaft_deceleration"), seed=11)
    table = tabulate(VESSEL, record, settings("shaft_deceleration"))
    assert table.events > 200
    assert table.found_in_time >= 0.95 * table.events
    assert table.missed <= 0.01 * table.events


@pytest.mark.parametrize("method", METHODS)
def test_no_false_alarm_in_an_hour_of_moderate_sea(method: str) -> None:
    """With n_min for the largest advance speed that comes: 6 Hz for the aft thrusters in this sea instead of 5 Hz."""
    trial = moderate_sea_trial(VESSEL, 3600.0, seed=3)
    gains = VESSEL.drivers.ventilation
    assert gains is not None
    fastest = float(np.abs(trial.advance_speed).max())
    speed_min = tuple(
        max(least, least_speed(gains.on, TORQUE_SLOPE, fastest, thruster.propeller.diameter))
        for least, thruster in zip(gains.speed_min, VESSEL.thrusters, strict=True)
    )
    assert 5.0 < speed_min[2] < 7.0
    record = sail(VESSEL, trial, settings(method, speed_min=speed_min), seed=3, torque_slope=TORQUE_SLOPE)
    assert not record.ventilating.any()
    # The sea does make the loss factor vary, and the shafts turn both ways above n_min.
    aft = record.shaft_speed[:, 2:]
    assert np.ptp(record.beta_q[:, 2:][np.abs(aft) > 8.0]) > 0.5
    assert aft.min() < -18.0
    assert aft.max() > 20.0
    # H_s = 2 m and 1 m/s at a scale of 1:30.
    assert np.abs(trial.advance_speed).mean() == pytest.approx(1.0 / math.sqrt(30.0), rel=0.1)
    # Half the slope, that of a propeller in a duct, needs no more than the printed 5 Hz.
    assert not sail(VESSEL, trial, settings(method), 3, 0.5 * TORQUE_SLOPE).ventilating.any()


def test_the_compiled_bench_does_what_the_drivers_do() -> None:
    """No ventilation and no advance speed: Drivers themselves, and shafts in forty small steps."""
    trial = moderate_sea_trial(VESSEL, 30.0, seed=4)
    still = Trial(trial.thrust, None, np.zeros_like(trial.advance_speed))
    record = sail(VESSEL, still, seed=4)
    drivers = Drivers(VESSEL)
    load = VESSEL.propellers.torque_per_speed_squared
    inertia = 2.0 * math.pi * np.array([t.shaft.inertia for t in VESSEL.thrusters])
    noise = sensor_noise(VESSEL, len(still.thrust), 4)
    speed, torque, azimuth = np.zeros(4), np.zeros(4), VESSEL.fixed_direction
    limit = np.array([t.shaft.torque_max for t in VESSEL.thrusters])
    worst_speed = worst_beta = 0.0
    for k, command in enumerate(still.thrust):
        worst_speed = max(worst_speed, float(np.abs(speed - record.shaft_speed[k]).max()))
        output = drivers.step(DriverInputs(command, azimuth, 0.0, speed + noise[k], torque, azimuth), DT)
        worst_beta = max(worst_beta, float(np.abs(output.beta_q - record.estimate[k]).max()))
        torque = output.torque.clip(-limit, limit)
        for _ in range(40):
            middle = speed + DT / 80.0 * (torque - load * speed * np.abs(speed)) / inertia
            speed = speed + DT / 40.0 * (torque - load * middle * np.abs(middle)) / inertia
    # The midpoint rule's error: (0.5 ms over a time constant of 0.02 s)^2 of a speed of 40 Hz, each time it changes.
    assert worst_speed < 1e-3
    assert worst_beta < 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_reversals_and_rapid_changes_are_never_flagged(method: str) -> None:
    """Steps between full ahead, full astern and all between, at the vessel's thrust rate, on calm water."""
    steps, n = round(600.0 / DT), len(VESSEL.thrusters)
    random = np.random.default_rng(2)
    share = random.choice([-1.0, -0.6, -0.2, 0.0, 0.2, 0.6, 1.0], (steps // 60 + 1, n))[np.arange(steps) // 60]
    thrust = np.where(share >= 0.0, share * VESSEL.thrust_max, -share * VESSEL.thrust_min)
    record = sail(VESSEL, Trial(thrust, None, np.zeros((steps, n))), settings(method), seed=2)
    assert not record.ventilating.any()
    speed = record.shaft_speed[:, 2]
    assert (np.diff(np.sign(speed[np.abs(speed) > 1.0])) != 0.0).sum() > 100  # reversals
    assert np.abs(np.diff(speed)).max() / DT > 10.0  # faster than (B.43) allows


def test_the_table_counts_what_a_record_shows() -> None:
    """By hand: an event found at once, one found late, one missed, a short one, a false alarm, an early one."""
    steps = 1000
    beta, speed = np.ones((steps, 4)), np.full((steps, 4), 10.0)
    flag = np.zeros((steps, 4), dtype=np.bool_)
    for start, length in ((100, 50), (300, 50), (500, 50), (600, 20)):
        beta[start : start + length, 2] = 0.3
    flag[105:150, 2] = flag[325:350, 2] = True
    flag[800:810, 2] = True  # wet
    beta[900:920, 2], flag[905:910, 2] = 0.6, True  # between on and off
    table = tabulate(VESSEL, Record(speed, beta, beta, flag))
    assert (table.events, table.found, table.found_in_time, table.missed) == (3, 2, 1, 1)
    assert (table.flags, table.early, table.false_alarms) == (4, 1, 1)
    np.testing.assert_allclose(table.delays, [0.1, 0.5])
    assert table.in_time.tolist() == [True, False, False]
    assert table.speeds.tolist() == [10.0] * 3
    assert table.depths.tolist() == [0.3] * 3


def test_what_is_refused() -> None:
    with pytest.raises(InputError, match=r"method: expected torque_rate or shaft_deceleration, found 'guess'"):
        campaign(VESSEL, "guess", 1.0)
    dry = VESSEL.model_copy(update={"ventilation": None})
    with pytest.raises(InputError, match=r"ventilation: expected this section in vessel 'cybership3', found none"):
        sail(dry, ventilation_trial(VESSEL, 1.0, 0))
    bare = VESSEL.model_copy(update={"drivers": VESSEL.drivers.model_copy(update={"ventilation": None})})
    with pytest.raises(InputError, match=r"drivers.ventilation: expected this section"):
        ventilation_trial(bare, 1.0, 0)
