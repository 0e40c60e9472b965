"""The closed-form shaft step against hand-worked cases, its own composition, and a numerical integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from marine_model import Vessel, load_vessel, vessel_names
from vessel_sim.shaft import Shaft, shafts

LOAD = 2.6e-4  # N m s^2, an aft thruster of the model ship
INERTIA = 3.0e-4  # kg m^2

speeds = st.floats(-30.0, 30.0)
torques = st.floats(-0.2, 0.2)
frictions = st.tuples(st.sampled_from([0.0, 1e-4, 2e-3]), st.sampled_from([0.0, 1e-3, 2e-2]))
durations = st.floats(1e-4, 1.0)


def test_final_speed_balances_the_propeller_torque() -> None:
    # Q = c n^2: 0.104 N m over 2.6e-4 N m s^2 is 400 Hz^2.
    assert Shaft(INERTIA, LOAD).advance(0.0, 0.104, 60.0) == pytest.approx(20.0, rel=1e-12)
    assert Shaft(INERTIA, LOAD).advance(0.0, -0.104, 60.0) == pytest.approx(-20.0, rel=1e-12)


def test_final_speed_with_friction() -> None:
    # 0.104 + 0.002 + 20 * 0.001 N m hold 20 Hz against propeller, Coulomb and viscous friction.
    shaft = Shaft(INERTIA, LOAD, viscous=0.001, static=0.002)
    assert shaft.advance(5.0, 0.126, 60.0) == pytest.approx(20.0, rel=1e-12)


def test_start_from_rest_follows_tanh() -> None:
    # 2 pi J dn/dt = Q - c n^2 from rest: n = n_inf tanh(t n_inf c / (2 pi J)).
    t = 0.1
    expected = 20.0 * math.tanh(t * 20.0 * LOAD / (2.0 * math.pi * INERTIA))
    assert Shaft(INERTIA, LOAD).advance(0.0, 0.104, t) == pytest.approx(expected, rel=1e-12)


def test_coasting_shaft_slows_down_as_one_over_time() -> None:
    t = 0.3
    expected = 10.0 / (1.0 + 10.0 * LOAD * t / (2.0 * math.pi * INERTIA))
    assert Shaft(INERTIA, LOAD).advance(10.0, 0.0, t) == pytest.approx(expected, rel=1e-12)


def test_coulomb_friction_holds_a_shaft_at_rest() -> None:
    shaft = Shaft(INERTIA, LOAD, static=0.01)
    assert shaft.advance(0.0, 0.01, 10.0) == 0.0
    assert shaft.advance(0.0, -0.01, 10.0) == 0.0
    assert shaft.advance(0.0, 0.0101, 10.0) > 0.0
    # A coasting shaft stops, and stays stopped, under less torque than the friction.
    assert shaft.advance(5.0, 0.005, 100.0) == 0.0
    assert shaft.advance(-5.0, 0.005, 100.0) == 0.0


@given(speed=speeds, torque=torques, friction=frictions, dt=durations, part=st.floats(0.01, 0.99))
def test_two_steps_are_one_step(
    speed: float, torque: float, friction: tuple[float, float], dt: float, part: float
) -> None:
    shaft = Shaft(INERTIA, LOAD, *friction)
    halfway = shaft.advance(speed, torque, part * dt)
    # Exact but for rounding; where the shaft creeps into rest the square roots lose half of the digits.
    assert shaft.advance(halfway, torque, (1.0 - part) * dt) == pytest.approx(
        shaft.advance(speed, torque, dt), rel=1e-9, abs=1e-7
    )


@given(speed=speeds, torque=torques, friction=frictions, dt=durations)
def test_mirror_image(speed: float, torque: float, friction: tuple[float, float], dt: float) -> None:
    shaft = Shaft(INERTIA, LOAD, *friction)
    assert shaft.advance(-speed, -torque, dt) == -shaft.advance(speed, torque, dt)


@pytest.mark.parametrize("viscous", [0.0, 2e-3])
@pytest.mark.parametrize(("speed", "torque"), [(0.0, 0.1), (22.0, -0.15), (-22.0, 0.15), (15.0, -0.001), (3.0, 0.16)])
def test_against_numerical_integration(speed: float, torque: float, viscous: float) -> None:
    dt = 0.4
    solution = solve_ivp(
        lambda _, n: (torque - LOAD * n * np.abs(n) - viscous * n) / (2.0 * math.pi * INERTIA),
        (0.0, dt),
        [speed],
        rtol=1e-10,
        atol=1e-10,
    )
    # Ten times the tolerance of the reference: it adds up over its steps.
    assert Shaft(INERTIA, LOAD, viscous).advance(speed, torque, dt) == pytest.approx(
        float(solution.y[0, -1]), rel=1e-8, abs=1e-8
    )


def test_reversal_with_static_friction_against_numerical_integration() -> None:
    static, torque, dt = 0.02, -0.15, 0.4

    def rate(_: float, n: np.ndarray) -> np.ndarray:
        friction = static * np.sign(n)
        return np.asarray((torque - LOAD * n * np.abs(n) - friction) / (2.0 * math.pi * INERTIA))

    def stops(_: float, n: np.ndarray) -> float:
        return float(n[0])

    stops.terminal = True  # type: ignore[attr-defined]
    down = solve_ivp(rate, (0.0, dt), [10.0], events=stops, rtol=1e-10, atol=1e-10)
    assert down.status == 1  # it does come to rest within dt
    # From rest the right side is that of a negative speed at once.
    up = solve_ivp(rate, (float(down.t[-1]), dt), [-1e-12], rtol=1e-10, atol=1e-12)
    # The event is located to about 1e-8 s.
    assert Shaft(INERTIA, LOAD, static=static).advance(10.0, torque, dt) == pytest.approx(float(up.y[0, -1]), rel=1e-6)


@pytest.mark.parametrize("name", vessel_names())
@pytest.mark.parametrize("steps", [1, 50])
def test_full_torque_reversals_of_every_thruster_stay_bounded(name: str, steps: int) -> None:
    """No overshoot at the time step of the vessel, nor at fifty times that: unconditionally stable."""
    vessel: Vessel = load_vessel(name)
    dt = steps * vessel.simulation.time_step
    load = vessel.propellers.torque_per_speed_squared
    for i, shaft in enumerate(shafts(vessel)):
        limit = vessel.thrusters[i].shaft.torque_max
        full = math.sqrt(limit / load[i])
        speed = full
        for k in range(400):
            torque = limit if (k // 100) % 2 else -limit
            after = shaft.advance(speed, torque, dt)
            assert abs(after) <= full * (1.0 + 1e-12)
            # Monotone towards the new balance, but for rounding once there.
            assert (after - speed) * torque >= -1e-12 * limit * full
            speed = after
        assert speed == pytest.approx(full, rel=0.05)  # 2 s bring the slowest shaft this close


@given(speed=speeds, friction=frictions, dt=durations)
def test_without_torque_a_shaft_only_loses_energy(speed: float, friction: tuple[float, float], dt: float) -> None:
    after = Shaft(INERTIA, LOAD, *friction).advance(speed, 0.0, dt)
    # Completing the square costs rounding of the offset Q_v / (2 c), 40 Hz at most here.
    assert abs(after) <= abs(speed) + 40.0 * 1e-15
    assert after * speed >= 0.0
