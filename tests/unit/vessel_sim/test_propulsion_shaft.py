"""The closed-form shaft step against hand-worked cases, its own composition, and a numerical integrator."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from marine_model import Vessel, load_vessel, vessel_names
from vessel_sim.propulsion.shaft import advance

LOAD = 2.6e-4  # N m s^2, an aft thruster of the model ship
INERTIA = 3.0e-4  # kg m^2

speeds = st.floats(-30.0, 30.0)
torques = st.floats(-0.2, 0.2)
# Loads: none (in air), all but none, that of the model ship. a_Q rho D^4 V_A is 2e-3 N m s at a_Q = 0.06, 0.5 m/s.
loads = st.tuples(st.sampled_from([0.0, 1e-12, 1e-6, LOAD]), st.one_of(st.just(0.0), st.floats(-4e-3, 4e-3)))
frictions = st.tuples(st.sampled_from([0.0, 1e-4, 2e-3]), st.sampled_from([0.0, 1e-3, 2e-2]))
durations = st.floats(1e-4, 0.5)


def turn(
    speed: float,
    torque: float,
    dt: float,
    load: tuple[float, float] = (LOAD, 0.0),
    friction: tuple[float, float] = (0.0, 0.0),
) -> float:
    return advance(speed, torque, INERTIA, *load, *friction, dt)


def integrated(
    speed: float, torque: float, dt: float, load: tuple[float, float], friction: tuple[float, float]
) -> float:
    """The same from an error-controlled integrator, one side of n = 0 after the other."""
    (c, a), (viscous, static) = load, friction

    def rate(_: float, n: np.ndarray, side: float) -> np.ndarray:
        # The equation of one side, continued smoothly over n = 0, so that the event is not at a kink.
        load_torque = side * c * n * n + side * a * n + viscous * n + static * side
        return np.asarray((torque - load_torque) / (2.0 * math.pi * INERTIA))

    def stops(_: float, n: np.ndarray, side: float) -> float:
        return float(n[0]) * side

    stops.terminal = True  # type: ignore[attr-defined]
    stops.direction = -1.0  # type: ignore[attr-defined]
    time = 0.0
    for _ in range(2):
        if speed == 0.0:
            if abs(torque) <= static + 1e-9:  # which turns the shaft by 3e-7 Hz in half a second
                return 0.0
            side = math.copysign(1.0, torque)
        else:
            side = math.copysign(1.0, speed)
        leg = solve_ivp(
            rate,
            (time, dt),
            [speed],
            args=(side,),
            events=stops,
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
        )
        if leg.status == 0:
            return float(leg.y[0, -1])
        time, speed = float(leg.t[-1]), 0.0
        if dt - time <= 0.0:
            return 0.0
    raise AssertionError("came to rest twice")


@given(speed=speeds, torque=torques, load=loads, friction=frictions, dt=durations)
@example(speed=10.0, torque=-0.15, load=(LOAD, 0.0), friction=(0.0, 0.02), dt=0.4)  # through rest
@example(speed=10.0, torque=0.001, load=(0.0, 0.0), friction=(0.0, 0.02), dt=0.4)  # rest in air
@example(speed=1.0, torque=0.0, load=(LOAD, -4e-3), friction=(0.0, 0.0), dt=0.5)  # windmilling
@example(speed=20.0, torque=-0.005, load=(LOAD, -4e-3), friction=(0.0, 0.0), dt=0.5)  # windmilling against the motor
@example(speed=1.0, torque=-0.005, load=(LOAD, -4e-3), friction=(0.0, 0.0), dt=0.5)  # too slow to windmill
@example(speed=-12.0, torque=0.1, load=(LOAD, 4e-3), friction=(2e-3, 1e-3), dt=0.5)
@example(speed=5.0, torque=0.1, load=(0.0, 0.0), friction=(0.0, 0.0), dt=0.5)  # nothing resists
def test_against_an_error_controlled_integrator(
    speed: float, torque: float, load: tuple[float, float], friction: tuple[float, float], dt: float
) -> None:
    if abs(speed) < 1e-9:
        speed = 0.0  # below the tolerance of the reference
    expected = integrated(speed, torque, dt, load, friction)
    # Tolerance of the reference is 1e-10 relative a step; it adds up, and the time of rest is found to some 1e-9 s
    # where the speed falls by up to 200 Hz/s.
    assert turn(speed, torque, dt, load, friction) == pytest.approx(expected, rel=1e-7, abs=1e-6)


def test_final_speed_balances_the_propeller_torque() -> None:
    # Q = c n^2: 0.104 N m over 2.6e-4 N m s^2 is 400 Hz^2.
    assert turn(0.0, 0.104, 60.0) == pytest.approx(20.0, rel=1e-12)
    assert turn(0.0, -0.104, 60.0) == pytest.approx(-20.0, rel=1e-12)


def test_final_speed_with_friction() -> None:
    # 0.104 + 0.002 + 20 * 0.001 N m hold 20 Hz against propeller, Coulomb and viscous friction.
    assert turn(5.0, 0.126, 60.0, friction=(0.001, 0.002)) == pytest.approx(20.0, rel=1e-12)


def test_advance_speed_takes_load_off() -> None:
    # 2.6e-4 * 400 - 1e-3 * 20 N m hold 20 Hz; going astern at that advance speed the load is larger by as much.
    assert turn(5.0, 0.084, 60.0, load=(LOAD, -1e-3)) == pytest.approx(20.0, rel=1e-12)
    assert turn(-5.0, -0.124, 60.0, load=(LOAD, -1e-3)) == pytest.approx(-20.0, rel=1e-12)


def test_windmilling() -> None:
    # Without motor torque c n = -a: 5.2e-3 / 2.6e-4 = 20 Hz, from above and from below; at rest it needs a push.
    load = (LOAD, -5.2e-3)
    for speed in (0.1, 19.0, 40.0):
        assert turn(speed, 0.0, 60.0, load) == pytest.approx(20.0, rel=1e-9)
    assert turn(0.0, 0.0, 60.0, load) == 0.0
    assert turn(-10.0, 0.0, 60.0, load) == pytest.approx(0.0, abs=1e-9)
    # A motor that holds back with 0.02 N m: c n^2 - 5.2e-3 n + 0.02 = 0 at 5.19 and 14.81 Hz; below 5.19 it stops
    # the propeller and drives it astern.
    root = math.sqrt(5.2e-3**2 - 4.0 * LOAD * 0.02)
    low, high = (5.2e-3 - root) / (2.0 * LOAD), (5.2e-3 + root) / (2.0 * LOAD)
    assert turn(low * 1.01, -0.02, 60.0, load) == pytest.approx(high, rel=1e-9)
    assert turn(low * 0.99, -0.02, 60.0, load) < 0.0


def test_start_from_rest_follows_tanh() -> None:
    # 2 pi J dn/dt = Q - c n^2 from rest: n = n_inf tanh(t n_inf c / (2 pi J)).
    t = 0.1
    expected = 20.0 * math.tanh(t * 20.0 * LOAD / (2.0 * math.pi * INERTIA))
    assert turn(0.0, 0.104, t) == pytest.approx(expected, rel=1e-12)


def test_coasting_shaft_slows_down_as_one_over_time() -> None:
    t = 0.3
    expected = 10.0 / (1.0 + 10.0 * LOAD * t / (2.0 * math.pi * INERTIA))
    assert turn(10.0, 0.0, t) == pytest.approx(expected, rel=1e-12)


def test_in_air_the_shaft_is_a_first_order_lag() -> None:
    t, viscous, angular = 0.7, 2e-3, 2.0 * math.pi * INERTIA
    final, decay = 0.05 / viscous, math.exp(-t * viscous / angular)
    assert turn(8.0, 0.05, t, (0.0, 0.0), (viscous, 0.0)) == pytest.approx(final + (8.0 - final) * decay, rel=1e-12)
    assert turn(8.0, 0.05, t, (0.0, 0.0)) == pytest.approx(8.0 + 0.05 * t / angular, rel=1e-12)


@given(speed=speeds, torque=torques, a=st.floats(-4e-3, 4e-3), friction=frictions, dt=durations)
def test_almost_no_load_is_almost_none(
    speed: float, torque: float, a: float, friction: tuple[float, float], dt: float
) -> None:
    # c n^2 is 1e-15 of 30^2 N m, which turns the shaft by 1e-9 Hz in half a second; a reversal may double it.
    assert turn(speed, torque, dt, (1e-15, a), friction) == pytest.approx(
        turn(speed, torque, dt, (0.0, a), friction), rel=1e-9, abs=1e-8
    )


def test_coulomb_friction_holds_a_shaft_at_rest() -> None:
    hold = partial(turn, friction=(0.0, 0.01))
    assert hold(0.0, 0.01, 10.0) == 0.0
    assert hold(0.0, -0.01, 10.0) == 0.0
    assert hold(0.0, 0.0101, 10.0) > 0.0
    # A coasting shaft stops, and stays stopped, under less torque than the friction.
    assert hold(5.0, 0.005, 100.0) == 0.0
    assert hold(-5.0, 0.005, 100.0) == 0.0


@given(speed=speeds, torque=torques, load=loads, friction=frictions, dt=durations, part=st.floats(0.01, 0.99))
def test_two_steps_are_one_step(
    speed: float, torque: float, load: tuple[float, float], friction: tuple[float, float], dt: float, part: float
) -> None:
    halfway = turn(speed, torque, part * dt, load, friction)
    # Exact but for rounding; where the shaft creeps into rest the square roots lose half of the digits.
    assert turn(halfway, torque, (1.0 - part) * dt, load, friction) == pytest.approx(
        turn(speed, torque, dt, load, friction), rel=1e-9, abs=1e-7
    )


@pytest.mark.parametrize("z", [0.25, -0.25])
def test_no_jump_where_the_short_form_ends(z: float) -> None:
    """s^2 t^2 = z is where the ratio of polynomials hands over to roots and exponentials."""
    angular, speed = 2.0 * math.pi * INERTIA, 20.0
    # s^2 = (c / 2 pi J) (Q / 2 pi J) without linear load.
    edge = math.sqrt(abs(z) * angular**2 / (LOAD * 0.05))
    torque = math.copysign(0.05, z)
    below, above = (turn(speed, torque, edge * (1.0 + e)) for e in (-1e-9, 1e-9))
    at_most = (0.05 + LOAD * speed**2) / angular * 2e-9 * edge  # what the shaft speed changes by meanwhile
    assert abs(above - below) <= at_most + 1e-14 * speed
    # The closed forms of a shaft under constant torque.
    balance, x = math.sqrt(0.05 / LOAD), math.sqrt(abs(z))
    if z > 0.0:
        expected = balance * math.tanh(math.atanh(balance / speed) + x) ** -1
    else:
        expected = balance * math.tan(math.atan(speed / balance) - x)
    assert below == pytest.approx(expected, rel=1e-8)
    assert turn(speed, torque, 0.999 * edge) == pytest.approx(
        turn(turn(speed, torque, 0.5 * edge), torque, 0.499 * edge), rel=1e-13
    )


@given(speed=speeds, torque=torques, load=loads, friction=frictions, dt=durations)
def test_mirror_image(
    speed: float, torque: float, load: tuple[float, float], friction: tuple[float, float], dt: float
) -> None:
    c, a = load
    assert turn(-speed, -torque, dt, (c, -a), friction) == -turn(speed, torque, dt, load, friction)


@pytest.mark.parametrize("name", vessel_names())
@pytest.mark.parametrize("steps", [1, 50])
def test_full_torque_reversals_of_every_thruster_stay_bounded(name: str, steps: int) -> None:
    """No overshoot at the time step of the vessel, nor at fifty times that: unconditionally stable."""
    vessel: Vessel = load_vessel(name)
    dt = steps * vessel.simulation.time_step
    load = vessel.propellers.torque_per_speed_squared.tolist()
    for i, thruster in enumerate(vessel.thrusters):
        drive = thruster.shaft
        limit = drive.torque_max
        full = math.sqrt(limit / load[i])
        speed = full
        for k in range(400):
            torque = limit if (k // 100) % 2 else -limit
            after = advance(
                speed, torque, drive.inertia, load[i], 0.0, drive.friction_viscous, drive.friction_static, dt
            )
            assert abs(after) <= full * (1.0 + 1e-12)
            # Monotone towards the new balance, but for rounding once there.
            assert (after - speed) * torque >= -1e-12 * limit * full
            speed = after
        assert speed == pytest.approx(full, rel=0.05)  # 2 s bring the slowest shaft this close


@given(speed=speeds, c=st.sampled_from([0.0, 1e-6, LOAD]), friction=frictions, dt=durations)
def test_without_torque_in_still_water_a_shaft_only_loses_energy(
    speed: float, c: float, friction: tuple[float, float], dt: float
) -> None:
    after = turn(speed, 0.0, dt, (c, 0.0), friction)
    assert abs(after) <= abs(speed) * (1.0 + 1e-15)  # rounding
    assert after * speed >= 0.0
