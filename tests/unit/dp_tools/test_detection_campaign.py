"""Detection on simulated ventilation, in a sea without any, and in reversals: what issue and docs promise."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from dp_tools.detection_campaign import (
    METHODS,
    Record,
    Trial,
    campaign,
    least_shaft_speed,
    merge,
    moderate_sea_trial,
    sail,
    tabulate,
    ventilation_trial,
)
from dp_tools.detection_campaign.moderate_sea import current_speed, moderate_sea, orbital_motion
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.sections import BollardData
from thruster_drivers import DriverSettings
from thruster_drivers.ventilation import VentilationSettings
from thruster_drivers.ventilation.loss_factor import allowed_noise, least_speed
from vessel_sim.waves import IrregularSea

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
SAMPLE = VESSEL.measurement.sample_time
PRINTED = (50.0, 50.0, 5.0, 5.0)  # Hz, [Ruth] (B.41)


def settings(method: str, **changes: object) -> DriverSettings:
    return DriverSettings(ventilation=VentilationSettings.model_validate({"method": method, **changes}))


def steps_of_thrust(duration: float, seed: int) -> FloatArray:
    """Full ahead, full astern and all between, a new one every 1.2 s."""
    steps, n, length = round(duration / DT), len(VESSEL.thrusters), round(1.2 / DT)
    random = np.random.default_rng(seed)
    share = random.choice([-1.0, -0.6, -0.2, 0.0, 0.2, 0.6, 1.0], (steps // length + 1, n))[np.arange(steps) // length]
    return np.where(share >= 0.0, share * VESSEL.thrust_max, -share * VESSEL.thrust_min)


@pytest.mark.parametrize(("speed_min", "slowest"), [((), 15.0), (PRINTED, 9.0)], ids=["vessel file", "printed"])
def test_every_event_is_found_within_two_samples(speed_min: tuple[float, ...], slowest: float) -> None:
    """(5.14)-(5.15) at 50 Hz, the default, on ventilation of varied depth and speed."""
    chosen = settings("torque_rate", speed_min=speed_min)
    table = tabulate(VESSEL, sail(VESSEL, ventilation_trial(VESSEL, 300.0, 11, speed_min or None), chosen, 11), chosen)
    assert table.events > 60  # of two thrusters
    assert (table.missed, table.found_in_time, table.false_alarms) == (0, table.events, 0)
    assert table.delays.max() <= 2.0 * SAMPLE + 1e-9  # rounding
    assert table.hours == pytest.approx(1.0 / 6.0)
    assert table.speeds.min() < slowest
    assert table.speeds.max() > 18.0
    assert table.depths.min() < 0.1
    assert table.depths.max() > 0.4


def test_the_slow_form_finds_nearly_all() -> None:
    """(B.41)-(B.44) at 5 Hz; what is late is slow or begins in a rapid reduction."""
    chosen = settings("shaft_deceleration")
    table = tabulate(VESSEL, sail(VESSEL, ventilation_trial(VESSEL, 300.0, seed=11), chosen, seed=11), chosen)
    assert table.events > 60
    assert table.found_in_time >= 0.95 * table.events  # 98.8 % over 20 thruster hours
    assert table.missed <= 0.01 * table.events


@pytest.mark.parametrize("law", ["torque", "power", "combined"])
def test_under_other_laws(law: str) -> None:
    """Where torque or power is kept, not the shaft speed, the shaft races while the propeller draws air."""
    chosen = DriverSettings(controller=law)
    record = sail(VESSEL, ventilation_trial(VESSEL, 120.0, seed=11), chosen, seed=11)
    table = tabulate(VESSEL, record, chosen)
    assert table.events > 20
    assert (table.missed, table.found_in_time, table.false_alarms) == (0, table.events, 0)


@pytest.mark.parametrize(("method", "duration"), [("torque_rate", 600.0), ("shaft_deceleration", 300.0)])
def test_no_false_alarm_in_a_moderate_sea(method: str, duration: float) -> None:
    """Twenty minutes of two thrusters; what hours of it show is in the docs."""
    trial = moderate_sea_trial(VESSEL, duration, seed=3)
    record = sail(VESSEL, trial, settings(method), seed=3)
    table = tabulate(VESSEL, record, settings(method))
    assert table.hours == pytest.approx(duration / 1800.0)
    assert (table.events, table.flags) == (0, 0)
    assert np.all(record.torque_loss == 1.0)
    # The sea does make the loss factor vary, and the shafts turn both ways above n_min.
    aft, estimate = record.shaft_speed[:, 2:], record.estimate[:, 2:]
    assert np.ptp(estimate[np.abs(aft) > 11.2]) > 0.5
    assert aft.min() < -18.0
    assert aft.max() > 20.0
    # H_s = 2 m and 1 m/s at a scale of 1:30.
    assert np.abs(trial.advance_speed).mean() == pytest.approx(1.0 / math.sqrt(30.0), rel=0.1)


def test_least_shaft_speeds_of_the_vessel_file_follow_from_sea_and_noise() -> None:
    gains = VESSEL.drivers.ventilation
    assert gains is not None
    interval = gains.false_alarm_interval
    noise = allowed_noise(gains.on, gains.off, interval, DT)
    propellers = [thruster.propeller for thruster in VESSEL.thrusters]
    slope = np.array(
        [p.torque_slope / p.torque_coefficient for p in propellers if isinstance(p, BollardData)]  # all of them
    )
    found = least_shaft_speed(VESSEL, slope, gains.on, noise, interval)
    assert np.all(found[2:] <= gains.speed_min[2:])
    assert np.all(gains.speed_min[2:] <= found[2:] + 0.1)  # rounded up
    # By hand: at n_min the mean of beta_Q is so many standard deviations above `on`.
    sigma, period = orbital_motion(VESSEL)
    for j, propeller in enumerate(propellers):
        loss = abs(slope[j]) / (found[j] * propeller.diameter)
        spread = math.hypot(loss * sigma[j], noise)
        above = 1.0 - loss * current_speed(VESSEL) - gains.on
        assert above / spread == pytest.approx(math.sqrt(2.0 * math.log(interval / period[j])))
    # Without noise it is what the largest advance speed alone asks for.
    fastest = current_speed(VESSEL) + sigma[2] * math.sqrt(2.0 * math.log(interval / period[2]))
    alone = least_shaft_speed(VESSEL, slope, gains.on, 0.0, interval)[2]
    assert alone == pytest.approx(least_speed(gains.on, slope[2], fastest, propellers[2].diameter))
    with pytest.raises(InputError, match=r"noise: expected less than 0.09\d* of beta_Q, found 0.2"):
        least_shaft_speed(VESSEL, slope, gains.on, 0.2, interval)


def test_the_sea_has_the_spread_that_its_spectrum_says() -> None:
    sea, time = IrregularSea(moderate_sea(VESSEL), 0.0, seed=1), np.arange(0.0, 3600.0, 0.1)
    orbital = sea.particle_velocity(0.0, 0.0, 0.115, time)[:, 0]
    sigma, period = orbital_motion(VESSEL)
    # 3800 waves of 200 components: the spread of both is known to a few hundredths.
    assert orbital.std() == pytest.approx(sigma[2], rel=0.05)
    upward = np.count_nonzero((orbital[:-1] < 0.0) & (orbital[1:] >= 0.0))
    assert 3600.0 / upward == pytest.approx(period[2], rel=0.05)


@pytest.mark.parametrize("method", METHODS)
def test_reversals_and_rapid_changes_are_never_flagged(method: str) -> None:
    """As fast as the thrust rate lets them, on calm water."""
    thrust = steps_of_thrust(300.0, seed=2)
    record = sail(VESSEL, Trial(thrust, None, np.zeros(thrust.shape)), settings(method), seed=2)
    assert not record.ventilating.any()
    speed = record.shaft_speed[:, 2]
    assert (np.diff(np.sign(speed[np.abs(speed) > 1.0])) != 0.0).sum() > 50  # reversals
    assert np.abs(np.diff(speed)).max() / DT > 10.0  # faster than (B.43) allows


@pytest.mark.parametrize("method", METHODS)
def test_reversals_in_a_current_are_never_flagged(method: str) -> None:
    """What the current takes from the torque one way of turning says nothing about the other.

    0.3 m/s takes beta_Q below `on` up to 4.9 Hz only.
    """
    thrust = steps_of_thrust(300.0, seed=5)
    trial = Trial(thrust, None, np.where(np.arange(4) % 2 == 0, 0.3, -0.3) * np.ones(thrust.shape))
    assert not sail(VESSEL, trial, settings(method, speed_min=(50.0, 50.0, 6.0, 6.0)), seed=5).ventilating.any()


def test_the_table_counts_what_a_record_shows() -> None:
    """By hand: an event found at once, one found late, one missed, a short one, a false alarm, an early one."""
    steps = 1000
    left, speed = np.ones((steps, 4)), np.full((steps, 4), 12.0)
    flag = np.zeros((steps, 4), dtype=np.bool_)
    for start, length in ((100, 50), (300, 50), (500, 50), (600, 20)):
        left[start : start + length, 2] = 0.3
    flag[105:150, 2] = flag[325:350, 2] = True
    flag[800:810, 2] = True  # wet
    left[900:920, 2], flag[905:910, 2] = 0.6, True  # between on and off
    table = tabulate(VESSEL, Record(speed, left, left, flag))
    assert (table.events, table.found, table.found_in_time, table.missed) == (3, 2, 1, 1)
    assert (table.flags, table.early, table.false_alarms) == (4, 1, 1)
    np.testing.assert_allclose(table.delays, [0.1, 0.5])
    np.testing.assert_array_equal(table.delays_in_own_samples, [5.0, 25.0])
    assert table.in_time.tolist() == [True, False, False]
    assert table.speeds.tolist() == [12.0] * 3
    assert table.depths.tolist() == [0.3] * 3

    twice = merge([table, table])
    for field in dataclasses.fields(table):
        one, both = getattr(table, field.name), getattr(twice, field.name)
        if field.name in ("method", "own_sample"):
            assert one == both
        elif isinstance(one, np.ndarray):
            np.testing.assert_array_equal(both, np.concatenate([one, one]))
        else:
            assert both == pytest.approx(2 * one)
    slow = tabulate(VESSEL, Record(speed, left, left, flag), settings("shaft_deceleration"))
    np.testing.assert_array_equal(slow.delays_in_own_samples, [1.0, 3.0])
    with pytest.raises(InputError, match=r"tables: expected some, of one method, found \[\('shaft"):
        merge([table, slow])
    with pytest.raises(InputError, match=r"tables: expected some, of one method, found none"):
        merge([])


def test_processes_make_no_difference() -> None:
    told: list[tuple[int, int]] = []
    alone = campaign(
        VESSEL, "torque_rate", 60.0, seed=1, processes=1, progress=lambda done, total: told.append((done, total))
    )
    assert told == [(1, 2), (2, 2)]
    assert [table.hours for table in alone] == pytest.approx([1.0 / 60.0, 2.0 / 60.0])  # of two thrusters
    assert alone[0].events > 0
    for one, other in zip(alone, campaign(VESSEL, "torque_rate", 60.0, seed=1, processes=2), strict=True):
        for field in dataclasses.fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


def test_what_is_refused() -> None:
    with pytest.raises(InputError, match=r"method: expected torque_rate or shaft_deceleration, found 'guess'"):
        campaign(VESSEL, "guess", 1.0)
    with pytest.raises(InputError, match=r"duration: expected .* above 0, found -1"):
        campaign(VESSEL, "torque_rate", -1.0)
    dry = VESSEL.model_copy(update={"ventilation": None})
    with pytest.raises(InputError, match=r"ventilation: expected this section in vessel 'cybership3', found none"):
        sail(dry, ventilation_trial(VESSEL, 1.0, 0))
    bare = VESSEL.model_copy(update={"drivers": VESSEL.drivers.model_copy(update={"ventilation": None})})
    for refused in (lambda: ventilation_trial(bare, 1.0, 0), lambda: sail(bare, moderate_sea_trial(bare, 1.0, 0))):
        with pytest.raises(InputError, match=r"drivers.ventilation: expected this section"):
            refused()
