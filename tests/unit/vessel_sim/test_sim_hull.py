"""The hull model against its matrix form, its invariants, and the form with absolute velocity in a current."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.frames import rotation
from vessel_sim import CurrentSettings, PropulsionSettings, Simulator, SimulatorInputs, SimulatorSettings
from vessel_sim.hull import Hull
from vessel_sim.sail import FORCE_N, FORCE_X

Array = NDArray[np.float64]
VESSEL = load_vessel("cybership3")
velocities = st.tuples(st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


def coriolis(mass: Array, nu: Array) -> Array:
    """C(nu) of a symmetric mass matrix (Fossen), shape (3, 3)."""
    p = mass @ nu
    return np.array([[0.0, 0.0, -p[1]], [0.0, 0.0, p[0]], [p[1], -p[0], 0.0]])


def damping_force(vessel: Vessel, nu: Array) -> Array:
    data = vessel.on_surface()[0]
    return np.array(data.linear_damping) @ nu + np.array(data.quadratic_damping) * np.abs(nu) * nu


@given(nu=velocities, tau=st.tuples(*[st.floats(-20.0, 20.0)] * 3))
def test_acceleration_solves_the_equation_of_motion(
    nu: tuple[float, float, float], tau: tuple[float, float, float]
) -> None:
    mass = np.array(VESSEL.on_surface()[0].rigid_body_mass) + np.array(VESSEL.on_surface()[0].added_mass)
    v = np.array(nu)
    acceleration = np.array(Hull(VESSEL).acceleration(*nu, *tau))
    residual = mass @ acceleration + coriolis(mass, v) @ v + damping_force(VESSEL, v) - np.array(tau)
    assert np.abs(residual).max() < 1e-12 * 200.0  # rounding of terms up to some 200 N


@given(nu=velocities)
def test_coriolis_forces_do_no_work(nu: tuple[float, float, float]) -> None:
    v = np.array(nu)
    power = float(np.array(Hull(VESSEL).hydrodynamic_force(*nu)) @ v)
    assert power == pytest.approx(-float(damping_force(VESSEL, v) @ v), rel=1e-9, abs=1e-12)
    assert power <= 0.0


def test_munk_moment_turns_the_bow_broadside() -> None:
    # (M_22 - M_11) u v with M_11 = 95.2, M_22 = 163.4; the linear sway-yaw damping adds -0.59 v.
    _, _, moment = Hull(VESSEL).hydrodynamic_force(0.5, -0.1, 0.0)
    assert moment == pytest.approx((95.2 - 163.4) * 0.5 * -0.1 + 0.59 * 0.1, rel=1e-12)


def test_moving_frame_agrees_with_the_form_in_absolute_velocity() -> None:
    """M_RB nu_dot + C_RB(nu) nu + M_A nu_r_dot + C_A(nu_r) nu_r + D(nu_r) nu_r = tau, current constant in NED."""
    data = VESSEL.on_surface()[0]
    rigid, added = np.array(data.rigid_body_mass), np.array(data.added_mass)
    current_ned = np.array([0.15 * math.cos(0.8), 0.15 * math.sin(0.8), 0.0])
    tau = np.array([2.0, 1.0, 0.6])

    def rate(_: float, x: Array) -> Array:
        heading, nu = x[2], x[3:]
        current = rotation(heading).T @ current_ned
        current_dot = np.array([nu[2] * current[1], -nu[2] * current[0], 0.0])
        relative = nu - current
        force = tau - coriolis(rigid, nu) @ nu - coriolis(added, relative) @ relative
        force += added @ current_dot - damping_force(VESSEL, relative)
        return np.concatenate([rotation(heading) @ nu, np.linalg.solve(rigid + added, force)])

    duration = 20.0
    reference = solve_ivp(rate, (0.0, duration), np.zeros(6), rtol=1e-11, atol=1e-12).y[:, -1]

    # Propellers at rest have no force without inflow: what moves the ship is the force from outside.
    settings = SimulatorSettings(
        current=CurrentSettings(speed=0.15, direction=0.8), propulsion=PropulsionSettings(inflow=False)
    )
    sim = Simulator(VESSEL, settings)
    sim._outside[FORCE_X : FORCE_N + 1] = tau
    dt = VESSEL.simulation.time_step
    still = SimulatorInputs(np.zeros(4), np.zeros(4))
    for _ in range(round(duration / dt)):
        output = sim.step(still, dt)
    # Second order at dt = 0.02 s; the convergence test shows the order.
    assert output.position == pytest.approx(reference[:3], abs=2e-6)
    assert output.velocity == pytest.approx(reference[3:], abs=2e-6)
    assert abs(reference[2]) > 1.0  # the ship has turned, so that the frames matter


def test_time_step_too_long_for_the_hull_is_refused() -> None:
    # The fastest linear decay of the model ship is yaw, 6.8 / 36.7 per second.
    content = VESSEL.model_dump()
    content["simulation"]["time_step"] = 2.0
    content["measurement"]["sample_time"] = 2.0
    slow = Vessel.model_validate(content)
    # 0.2 / (6.8 / 36.7 / s) is 1.079 s; the coupling to sway makes it less than a hundredth less.
    with pytest.raises(InputError, match=r"simulation\.time_step: expected at most 1\.07 s.*found 2\.0 s"):
        Hull(slow)
