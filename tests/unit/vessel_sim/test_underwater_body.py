"""The submerged body: its forces against matrix form and closed forms, what it does when left alone, its invariants."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.frames import attitude_rotation, attitude_to_quaternion, quaternion_to_attitude
from marine_model.underwater import Fins, UnderwaterBody
from vessel_sim.hull import Hull
from vessel_sim.underwater import SubmergedBody
from vessel_sim.underwater.columns import (
    DEPTH,
    HEADING,
    INVERSE,
    LINEAR,
    MOTION,
    QUATERNION,
    RIGID,
    THRUSTERS,
    VELOCITY,
)
from vessel_sim.underwater.columns import MASS as MASS_MATRIX
from vessel_sim.underwater.dive import move

Array = NDArray[np.float64]
MASS, HEIGHT = 200.0, 0.6
WEIGHT = MASS * GRAVITY
NONE = (1e-12,) * 6  # as good as no damping


# Without any symmetry.
VALUES: dict[str, Any] = {
    "buoyancy": WEIGHT,
    "centre_of_gravity": (0.03, -0.02, 0.06),
    "centre_of_buoyancy": (0.01, 0.01, -0.05),
    "inertia": ((17.0, 0.8, -0.5), (0.8, 31.0, 0.3), (-0.5, 0.3, 36.0)),
    "added_mass": (100.0, 180.0, 220.0, 8.0, 15.0, 14.0),
    "linear_damping": (20.0, 40.0, 50.0, 5.0, 8.0, 9.0),
    "quadratic_damping": (240.0, 430.0, 580.0, 20.0, 40.0, 41.0),
}


def body(**changed: Any) -> SubmergedBody:
    return SubmergedBody(UnderwaterBody(**(VALUES | changed)), MASS, HEIGHT)


def plain(**changed: Any) -> SubmergedBody:
    """A body with the symmetries of a vehicle: weight under buoyancy, both under the origin."""
    return body(
        **(
            {
                "centre_of_gravity": (0.0, 0.0, 0.06),
                "centre_of_buoyancy": (0.0, 0.0, -0.05),
                "inertia": ((17.0, 0.0, 0.0), (0.0, 31.0, 0.0), (0.0, 0.0, 36.0)),
            }
            | changed
        )
    )


def motion(
    *,
    depth: float = 5.0,
    attitude: tuple[float, float, float] = (0.0, 0.0, 0.0),
    velocity: tuple[float, ...] = (0.0,) * 6,
) -> Array:
    made = np.zeros(MOTION)
    made[DEPTH], made[HEADING] = depth, attitude[2]
    x, y, z, w = attitude_to_quaternion(*attitude)
    made[QUATERNION:VELOCITY] = w, x, y, z
    made[VELOCITY:RIGID] = velocity
    return made


def roll_pitch_heading(state: Array) -> tuple[float, float, float]:
    w, x, y, z = state[QUATERNION:VELOCITY].tolist()
    return quaternion_to_attitude(x, y, z, w)


def sail(
    of: SubmergedBody, state: Array, duration: float, dt: float, force: Array | None = None, current: Any = (0.0, 0.0)
) -> Array:
    """Move on under a force that stays, and return all states, the first included."""
    pushed = np.zeros(6) if force is None else np.array(force, dtype=np.float64)
    state[THRUSTERS:HEADING] = pushed
    states = [state.copy()]
    for _ in range(round(duration / dt)):
        move(of.coefficients, state, pushed, current, dt)
        states.append(state.copy())
    return np.array(states)


def skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def coriolis(mass: Array, nu: Array) -> Array:
    """C(nu) of a symmetric mass matrix, shape (6, 6): Fossen's theorem, skew-symmetric."""
    p = mass @ nu
    matrix = np.zeros((6, 6))
    matrix[:3, 3:] = matrix[3:, :3] = -skew(p[:3])
    matrix[3:, 3:] = -skew(p[3:])
    return matrix


velocities = st.tuples(*[st.floats(-2.0, 2.0)] * 6)
attitudes = st.tuples(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))


@given(nu=velocities)
def test_forces_of_the_water_are_those_of_the_matrices(nu: tuple[float, ...]) -> None:
    of, v, data = body(), np.array(nu), UnderwaterBody(**VALUES)
    damping = np.array(data.linear_damping) + np.array(data.quadratic_damping) * np.abs(v)
    expected = -coriolis(data.total_mass(MASS), v) @ v - damping * v
    # Rounding of terms of some thousand newtons.
    np.testing.assert_allclose(of.hydrodynamic_force(v), expected, atol=1e-9)


@given(nu=velocities)
def test_coriolis_forces_do_no_work_and_fins_only_take_it(nu: tuple[float, ...]) -> None:
    v = np.array(nu)
    of = body(linear_damping=NONE, quadratic_damping=(0.0,) * 6)
    # Rounding of the products of forces of a thousand newtons with speeds of 2 m/s.
    assert abs(of.hydrodynamic_force(v) @ v) < 1e-9
    winged = body(
        linear_damping=NONE, quadratic_damping=(0.0,) * 6, fins=Fins(x=-1.0, radius=0.5, sway=90.0, heave=70.0)
    )
    power = (winged.hydrodynamic_force(v) - of.hydrodynamic_force(v)) @ v
    across = 90.0 * (v[1] - v[5]) ** 2 + 70.0 * (v[2] + v[4]) ** 2 + (90.0 + 70.0) * (0.5 * v[3]) ** 2
    assert power == pytest.approx(-abs(v[0]) * across, rel=1e-9, abs=1e-9)


@given(attitude=attitudes, depth=st.floats(-1.0, 2.0))
def test_weight_and_buoyancy_by_rotation_matrix(attitude: tuple[float, float, float], depth: float) -> None:
    of, state = body(buoyancy=1.02 * WEIGHT), motion(depth=depth, attitude=attitude)
    turn = attitude_rotation(*attitude)
    centre_g, centre_b = np.array([0.03, -0.02, 0.06]), np.array([0.01, 0.01, -0.05])
    share = min(max(0.5 + (depth + (turn @ centre_b)[2]) / HEIGHT, 0.0), 1.0)
    weight = turn.T @ [0.0, 0.0, WEIGHT]
    lift = turn.T @ [0.0, 0.0, -1.02 * WEIGHT * share]
    expected = np.concatenate([weight + lift, np.cross(centre_g, weight) + np.cross(centre_b, lift)])
    np.testing.assert_allclose(of.restoring_force(state), expected, atol=1e-9)


def test_neutral_body_hovers() -> None:
    states = sail(plain(), motion(attitude=(0.0, 0.0, 0.7)), 20.0, 0.02)
    np.testing.assert_allclose(states[-1], states[0], atol=1e-12)


@pytest.mark.parametrize("which", ["roll", "pitch"])
def test_pendulum_swings_at_its_frequency(which: str) -> None:
    """omega^2 = (W z_g - B z_b) / (I + I_A - (m z_g)^2 / (m + m_A)): small, without damping.

    The swing goes with a sway or surge through the centre of gravity that nothing holds, which makes it lighter.
    """
    of = plain(linear_damping=NONE, quadratic_damping=(0.0,) * 6)
    i, inertia, moved = {"roll": (0, 17.0 + 8.0, MASS + 180.0), "pitch": (1, 31.0 + 15.0, MASS + 100.0)}[which]
    omega = math.sqrt(WEIGHT * (0.06 + 0.05) / (inertia - (MASS * 0.06) ** 2 / moved))
    tilt = [0.0, 0.0, 0.0]
    tilt[i] = 1e-3
    period = 2.0 * math.pi / omega
    dt = period / 400.0
    states = sail(of, motion(attitude=(tilt[0], tilt[1], tilt[2])), 3.0 * period, dt)
    angles = np.array([roll_pitch_heading(state)[i] for state in states])
    times = dt * np.arange(len(angles))
    # The cubic of the sine is 1e-6 / 16 of the frequency; the method leaves 1e-8 at 400 steps a period.
    np.testing.assert_allclose(angles, 1e-3 * np.cos(omega * times), atol=1e-3 * 1e-5)


@pytest.mark.parametrize("force", [10.0, 150.0, -300.0])
def test_terminal_speed_in_surge(force: float) -> None:
    """d1 u + d2 u |u| = F, all in one line."""
    level = plain(centre_of_gravity=(0.0, 0.0, 0.0), centre_of_buoyancy=(0.0, 0.0, 0.0))
    states = sail(level, motion(), 120.0, 0.05, np.array([force, 0.0, 0.0, 0.0, 0.0, 0.0]))
    speed = (math.sqrt(20.0**2 + 4.0 * 240.0 * abs(force)) - 20.0) / (2.0 * 240.0)
    assert states[-1, VELOCITY] == pytest.approx(math.copysign(speed, force), rel=1e-9)


def test_munk_moment_pitches_the_bow_up_when_it_sinks_under_way() -> None:
    """(M_33 - M_11) u w: towards broadside."""
    of = plain(linear_damping=NONE, quadratic_damping=(0.0,) * 6)
    force = of.hydrodynamic_force(np.array([1.0, 0.0, 0.2, 0.0, 0.0, 0.0]))
    assert force[4] == pytest.approx((220.0 - 100.0) * 0.2, rel=1e-9)


def test_energy_never_grows_by_itself() -> None:
    """Tumbling from any start, without thrust and current; at the surface as well."""
    random = np.random.default_rng(7)
    damped = body(buoyancy=1.01 * WEIGHT, fins=Fins(x=-0.5, radius=0.4, sway=50.0, heave=40.0))
    free = body(buoyancy=1.01 * WEIGHT, linear_damping=NONE, quadratic_damping=(0.0,) * 6)
    for of in (damped, free):
        for _ in range(3):
            start = motion(
                depth=float(random.uniform(-0.2, 1.0)),
                attitude=tuple(random.uniform(-1.0, 1.0, 3)),
                velocity=tuple(random.uniform(-1.0, 1.0, 6)),
            )
            energy = np.array([of.energy(state) for state in sail(of, start, 20.0, 0.01)])
            swing = energy[0] - energy.min() + 100.0
            # Kinks where the body comes out of the water cost the method its order; J out of some hundred.
            assert np.diff(energy).max() < 1e-4 * swing
            if of is damped:
                assert energy[-1] < energy[0] - 50.0
            else:
                np.testing.assert_allclose(energy, energy[0], atol=2e-3 * swing)


def test_energy_decays_in_the_frame_of_a_current() -> None:
    """A uniform current is another inertial frame: the same motion, carried along."""
    of, start = body(), motion(attitude=(0.3, -0.2, 0.5), velocity=(0.5, -0.3, 0.2, 0.4, -0.2, 0.3))
    still = sail(of, start.copy(), 10.0, 0.02)
    carried = sail(of, start.copy(), 10.0, 0.02, current=(0.3, -0.4))
    drift = 0.02 * np.arange(len(still))[:, None] * [0.3, -0.4]
    np.testing.assert_allclose(carried[:, :2], still[:, :2] + drift, atol=1e-11)
    np.testing.assert_allclose(carried[:, DEPTH:], still[:, DEPTH:], atol=1e-12)


def test_port_is_the_mirror_of_starboard() -> None:
    mirror = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    of = plain(fins=Fins(x=-0.5, radius=0.4, sway=50.0, heave=40.0))
    force = np.array([60.0, 30.0, -10.0, 2.0, 3.0, 15.0])
    attitude, velocity = (0.2, 0.1, 0.4), np.array([0.5, 0.2, -0.1, 0.3, 0.1, -0.2])
    one = sail(of, motion(attitude=attitude, velocity=tuple(velocity)), 20.0, 0.02, force)
    other = sail(of, motion(attitude=(-0.2, 0.1, -0.4), velocity=tuple(mirror * velocity)), 20.0, 0.02, mirror * force)
    # The arc tangent and sums in another order are all that differs.
    np.testing.assert_allclose(other[:, VELOCITY:RIGID], one[:, VELOCITY:RIGID] * mirror, atol=1e-11)
    np.testing.assert_allclose(other[:, [0, 1, 2, HEADING]], one[:, [0, 1, 2, HEADING]] * [1, -1, 1, -1], atol=1e-10)


def test_fourth_order_without_changing_thrust() -> None:
    of, force = (
        body(fins=Fins(x=-0.5, radius=0.4, sway=50.0, heave=40.0)),
        np.array([80.0, 30.0, -40.0, 3.0, -4.0, 15.0]),
    )
    ends = [
        sail(of, motion(velocity=(0.5, 0.3, -0.2, 0.4, 0.3, -0.5)), 4.0, dt, force)[-1] for dt in (0.08, 0.04, 0.02)
    ]
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    # 16 for order 4; damping |v| v has kinks where an axis stops, which lowers it a little here and there.
    assert 12.0 < ratio < 20.0


def test_quaternion_stays_of_length_one_and_heading_is_counted_on() -> None:
    of = plain(linear_damping=NONE, quadratic_damping=(0.0,) * 6)
    states = sail(of, motion(velocity=(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)), 20.0, 0.02)
    np.testing.assert_allclose((states[:, QUATERNION:VELOCITY] ** 2).sum(axis=1), 1.0, atol=1e-14)
    assert states[-1, HEADING] == pytest.approx(20.0, abs=1e-7)  # three turns and more


def test_it_goes_over_the_singularity_of_angles() -> None:
    """A looping: with the bow straight up, heading and roll jump, the motion does not."""
    of = plain(
        centre_of_gravity=(0.0, 0.0, 0.0),
        centre_of_buoyancy=(0.0, 0.0, 0.0),
        linear_damping=NONE,
        quadratic_damping=(0.0,) * 6,
    )
    states = sail(of, motion(velocity=(0.0, 0.0, 0.0, 0.0, 1.0, 0.0)), math.tau, math.tau / 400)
    assert max(abs(roll_pitch_heading(s)[1]) for s in states) == pytest.approx(math.pi / 2, abs=0.01)
    # Once round, the quaternion is its own negative; 400 steps leave 1e-9 of the turn.
    np.testing.assert_allclose(states[-1, QUATERNION:VELOCITY], -states[0, QUATERNION:VELOCITY], atol=1e-8)


def test_floats_where_weight_and_buoyancy_agree() -> None:
    of = plain(buoyancy=1.25 * WEIGHT, linear_damping=(500.0,) * 6)
    end = sail(of, motion(depth=1.0), 60.0, 0.02)[-1]
    # A share of 0.8 below the surface: z_b = 0.3 H. What is left of the swing has gone down by exp(-60 / 1.7).
    assert end[DEPTH] - 0.05 == pytest.approx(0.3 * HEIGHT, abs=1e-9)


PLANE = np.array([0, 1, 5])  # surge, sway, yaw
plane_velocities = st.tuples(st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@cache
def plane_and_ship() -> tuple[SubmergedBody, Hull]:
    """The same matrices twice, with the centre of gravity ahead of the origin and nothing out of the plane."""
    of = body(
        centre_of_gravity=(0.04, 0.0, 0.0),
        centre_of_buoyancy=(0.04, 0.0, 0.0),
        inertia=((17.0, 0.0, 0.0), (0.0, 31.0, 0.0), (0.0, 0.0, 36.0)),
    )
    added = np.diag([100.0, 180.0, 14.0])
    total = of.coefficients[MASS_MATRIX:INVERSE].reshape(6, 6)[np.ix_(PLANE, PLANE)]
    ship = load_vessel("cybership3")
    surface = ship.on_surface()[0].model_copy(
        update={
            "rigid_body_mass": total - added,
            "added_mass": added,
            "linear_damping": np.diag([20.0, 40.0, 9.0]),
            "quadratic_damping": (240.0, 430.0, 41.0),
        }
    )
    return of, Hull(ship.model_copy(update={"manoeuvring": surface}))


@given(nu=plane_velocities, tau=st.tuples(*[st.floats(-20.0, 20.0)] * 3))
def test_in_the_plane_it_is_the_hull_of_a_ship(nu: tuple[float, float, float], tau: tuple[float, float, float]) -> None:
    of, hull = plane_and_ship()
    state = motion(velocity=(nu[0], nu[1], 0.0, 0.0, 0.0, nu[2]))
    force = of.hydrodynamic_force(state[VELOCITY:RIGID]) + of.restoring_force(state)
    force[PLANE] += tau
    acceleration = of.coefficients[INVERSE:LINEAR].reshape(6, 6) @ force
    # Rounding of some hundred newtons over some hundred kilograms.
    np.testing.assert_allclose(acceleration[PLANE], hull.acceleration(*nu, *tau), atol=1e-12)
    np.testing.assert_allclose(acceleration[[2, 3, 4]], 0.0, atol=1e-12)


def test_time_step_too_long_is_refused() -> None:
    of = body()
    of.check_time_step(0.02, np.full(6, 300.0))
    with pytest.raises(InputError, match=r"simulation.time_step: expected at most .* s, a fifth of what is stable"):
        of.check_time_step(0.5, np.full(6, 300.0))
    # The faster it can go, the stiffer the damping.
    of.check_time_step(0.08, np.full(6, 1.0))
    with pytest.raises(InputError, match="time_step"):
        of.check_time_step(0.08, np.full(6, 3000.0))
