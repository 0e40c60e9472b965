"""The flag: each condition of (5.14)-(5.15) and (B.41)-(B.44), hysteresis, exclusion, lost sensors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thruster_drivers.ventilation import VentilationMonitor, VentilationSettings, tables

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
SAMPLE = round(VESSEL.measurement.sample_time / DT)
LOAD = VESSEL.propellers.torque_per_speed_squared
INERTIA = 2.0 * math.pi * np.array([t.shaft.inertia for t in VESSEL.thrusters])
METHODS = ("torque_rate", "shaft_deceleration")
FAST = np.array([20.0, 20.0, 20.0, 20.0])
AFT = (2, 3)


def monitor(method: str = "torque_rate", **changes: object) -> VentilationMonitor:
    return VentilationMonitor(VESSEL, VentilationSettings.model_validate({"method": method, **changes}))


def feed(
    watch: VentilationMonitor, speed: FloatArray, beta: float, steps: int, ramp: float | FloatArray = 0.0
) -> list[list[bool]]:
    """Hold the true loss factor, with shaft speeds that change by ``ramp`` Hz/s; return the flags."""
    flags = []
    for k in range(steps):
        before, now = speed + ramp * DT * k, speed + ramp * DT * (k + 1)
        torque = INERTIA * ramp + beta * LOAD * 0.5 * (before * np.abs(before) + now * np.abs(now))
        flags.append(watch.step(now, torque, DT).ventilating.tolist())
    return flags


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_loss_is_flagged_held_and_cleared(method: str, sign: float) -> None:
    watch = monitor(method)
    speed = sign * FAST
    wet = feed(watch, speed, 1.0, 5 * SAMPLE)
    assert not any(any(row) for row in wet)
    assert feed(watch, speed, 0.3, 2 * SAMPLE)[-1] == [False, False, True, True]  # n_min 50 Hz keeps the bow out
    assert feed(watch, speed, 0.7, 3 * SAMPLE)[-1] == [False, False, True, True]  # between on and off: held
    assert feed(watch, speed, 0.95, 2 * SAMPLE)[-1] == [False] * 4
    assert feed(watch, speed, 0.7, 3 * SAMPLE)[-1] == [False] * 4  # and held again
    assert watch.events.tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize("method", METHODS)
def test_below_the_least_speed_nothing_is_flagged(method: str) -> None:
    watch = monitor(method)
    slow = np.full(4, 4.5)  # n_min is 5 Hz
    feed(watch, slow, 1.0, SAMPLE)
    assert not any(any(row) for row in feed(watch, slow, 0.1, 20 * SAMPLE))
    assert feed(watch, FAST, 0.1, 6 * SAMPLE)[-1] == [False, False, True, True]


@pytest.mark.parametrize("method", METHODS)
def test_an_excluded_thruster_is_never_flagged_but_observed(method: str) -> None:
    watch = monitor(method, excluded=(False, False, True, False))
    feed(watch, FAST, 1.0, SAMPLE)
    assert feed(watch, FAST, 0.3, 3 * SAMPLE)[-1] == [False, False, False, True]
    state = watch.step(FAST, 0.3 * LOAD * FAST**2, DT)
    np.testing.assert_allclose(state.beta_q, 0.3, atol=0.01)  # settled
    assert state.beta_q2.tolist() == [1.0, 1.0, 1.0, pytest.approx(0.3, abs=0.01)]
    # Excluding it while it is flagged clears the flag.
    watch.apply(VentilationSettings.model_validate({"method": method, "excluded": (True,) * 4}))
    assert feed(watch, FAST, 0.3, 1)[-1] == [False] * 4


@pytest.mark.parametrize(("pace", "expected"), [(1.5, False), (0.5, True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_while_the_motor_torque_rises_fast_nothing_is_flagged(pace: float, expected: bool, sign: float) -> None:
    """(5.14): a torque that rises at ``pace`` times the limit, and a propeller that loses most of its load."""
    watch = monitor()
    limit = float(watch.parameters[2, tables.TORQUE_RATE_LIMIT])
    torque, speed = sign * LOAD * 100.0, np.full(4, sign * 10.0)
    feed(watch, speed, 1.0, SAMPLE)

    def run(beta: float, rate: float, steps: int) -> list[bool]:
        nonlocal torque, speed
        flags = []
        for _ in range(steps):
            torque = torque + sign * rate * DT
            h = DT / 20  # the shaft has a time constant of 0.1 s or more
            for _ in range(20):
                speed = speed + h * (torque - beta * LOAD * speed * np.abs(speed)) / INERTIA
            flags.append(bool(watch.step(speed, torque, DT).ventilating[2]))
        return flags

    # Five windows of the rate, so that it is known to 1 %.
    assert not any(run(1.0, pace * limit, round(5.0 * watch.parameters[2, tables.TORQUE_RATE_TIME] / DT)))
    assert any(run(0.25, pace * limit, 2 * SAMPLE)) is expected
    assert any(run(0.25, 0.0, 2 * SAMPLE))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rapid_reduction_is_not_flagged_whatever_the_sign_of_n(sign: float) -> None:
    """(B.43) holds for n > 0 as printed; for n < 0 it is the shaft speed's size that counts."""
    watch = monitor("shaft_deceleration", speed_min=(50.0, 50.0, 5.0, 5.0))  # printed
    feed(watch, sign * FAST, 1.0, 5 * SAMPLE)
    # 11 Hz/s, above the printed 10, for 1.2 s from 20 Hz down to 6.8 Hz, with three quarters of the torque lost.
    flags = feed(watch, sign * FAST, 0.25, 6 * SAMPLE, ramp=-sign * 11.0)
    assert not any(any(row) for row in flags)
    assert feed(watch, sign * (FAST - 13.2), 0.25, 5 * SAMPLE)[-1] == [False, False, True, True]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_slow_reduction_is_flagged_if_torque_is_lost_and_only_then(sign: float) -> None:
    """9 Hz/s: with (B.39) as printed, which leaves the inertia out, a wet propeller would show 0.4 at 11 Hz."""
    for beta, expected in ((1.0, False), (0.25, True)):
        watch = monitor("shaft_deceleration")
        feed(watch, sign * FAST, 1.0, 5 * SAMPLE)
        flags = feed(watch, sign * FAST, beta, 5 * SAMPLE, ramp=-sign * 9.0)
        assert any(row[2] for row in flags) is expected


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("lost", [math.nan, math.inf])
def test_a_lost_sensor_claims_no_loss(method: str, lost: float) -> None:
    watch = monitor(method)
    feed(watch, FAST, 1.0, SAMPLE)
    feed(watch, FAST, 0.3, 3 * SAMPLE)
    speed, torque = FAST.copy(), 0.3 * LOAD * FAST**2
    speed[2] = lost
    state = watch.step(speed, torque, DT)
    assert state.ventilating.tolist() == [False, False, False, True]
    assert state.beta_q[2] == 1.0
    assert state.lost.tolist() == [False, False, True, False]
    assert state.torque[2] == 0.0
    assert math.isnan(state.shaft_speed[2])
    torque = torque.copy()
    torque[3] = lost
    assert watch.step(speed, torque, DT).ventilating.tolist() == [False] * 4
    # They come back, without a past.
    assert feed(watch, FAST, 1.0, SAMPLE)[-1] == [False] * 4
    assert not watch.step(FAST, LOAD * FAST**2, DT).lost.any()
    assert feed(watch, FAST, 0.3, 3 * SAMPLE)[-1] == [False, False, True, True]


def test_the_memory_falls_at_once_and_rises_slowly() -> None:
    gains = VESSEL.drivers.ventilation
    assert gains is not None
    watch = monitor()
    feed(watch, FAST, 1.0, SAMPLE)
    feed(watch, FAST, 0.3, SAMPLE)
    low = watch.step(FAST, 0.3 * LOAD * FAST**2, DT).beta_q2[2]
    feed(watch, FAST, 1.0, SAMPLE)
    state = watch.step(FAST, LOAD * FAST**2, DT)
    assert state.beta_q[2] == pytest.approx(1.0, abs=0.01)  # settled
    assert low < 0.31
    assert state.beta_q2[2] <= low + gains.relax_rate * (SAMPLE + 1) * DT + 0.01


def test_the_pitch_now_sets_the_nominal_torque() -> None:
    watch = monitor()
    for _ in range(SAMPLE):
        state = watch.step(FAST, 0.4 * LOAD * FAST**2, DT, 0.4 * LOAD)
    np.testing.assert_allclose(state.beta_q, 1.0, atol=1e-9)  # exact: nothing changes
    np.testing.assert_allclose(state.torque, 0.4 * LOAD * FAST**2, rtol=1e-9)


def test_thresholds_are_the_vessels_until_others_are_given() -> None:
    for changes, beta, expected in (
        ({}, 0.55, False),
        ({"on": 0.6}, 0.55, True),
        ({"on": 0.2, "off": 0.9}, 0.3, False),
    ):
        watch = monitor(**changes)
        feed(watch, FAST, 1.0, SAMPLE)
        assert feed(watch, FAST, beta, 3 * SAMPLE)[-1][2] is expected


def test_what_is_refused() -> None:
    watch = monitor()
    with pytest.raises(InputError, match=r"ventilation.on: expected a number below ventilation.off = 0.8, found 0.85"):
        watch.apply(VentilationSettings(on=0.85))
    with pytest.raises(InputError, match=r"ventilation.excluded: expected 4 elements, one a thruster, found 1"):
        watch.apply(VentilationSettings(excluded=(True,)))
    with pytest.raises(ValueError, match=r"on must be below off, found 0.9 and 0.8"):
        VentilationSettings(on=0.9, off=0.8)
    with pytest.raises(InputError, match=r"shaft_speed: expected shape \(4,\), found \(3,\)"):
        watch.step(np.zeros(3), np.zeros(4), DT)
    with pytest.raises(InputError, match=r"torque: expected shape \(4,\), found \(1,\)"):
        watch.step(np.zeros(4), np.zeros(1), DT)
    with pytest.raises(InputError, match=r"dt: expected a number above 0, found 0.0"):
        watch.step(np.zeros(4), np.zeros(4), 0.0)
    drivers = VESSEL.drivers.model_copy(update={"ventilation": None})
    with pytest.raises(
        InputError, match=r"drivers.ventilation: expected this section in vessel 'cybership3', found none"
    ):
        VentilationMonitor(VESSEL.model_copy(update={"drivers": drivers}))
