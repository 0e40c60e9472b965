"""One step of the whole vessel, compiled: hull, waves, water at the thrusters, thrusters."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from vessel_sim.hull import acceleration
from vessel_sim.inflow import X, Y, inflow
from vessel_sim.propulsion.columns import (
    ADVANCE_SPEED_INPUT,
    AZIMUTH,
    AZIMUTH_RATE,
    SUBMERGENCE_INPUT,
    THRUST,
)
from vessel_sim.propulsion.readings import sensed
from vessel_sim.propulsion.step import GOOD, advance_rows, first_bad
from vessel_sim.waves.drift import drift_force

# Motion: what a step changes, shape (MOTION,).
NORTH, EAST, HEADING = 0, 1, 2  # low-frequency position, m, m, rad (not wrapped)
SURGE, SWAY, YAW_RATE = 3, 4, 5  # low-frequency velocity through the water, body frame
THRUSTER_X, THRUSTER_Y, THRUSTER_N = 6, 7, 8  # force of all thrusters, N, N, N m, body frame
MOTION = 9

# Outside: what is the same all through a step, shape (OUTSIDE,).
FORCE_X, FORCE_Y, FORCE_N = 0, 1, 2  # force from outside besides waves and water, N, N, N m, body frame
CURRENT_NORTH, CURRENT_EAST = 3, 4  # m/s
OUTSIDE = 5


@compiled
def sail(
    hull: FloatArray,
    motion: FloatArray,
    outside: FloatArray,
    components: FloatArray,
    response: FloatArray,
    decay: FloatArray,
    thrusters: FloatArray,
    parameters: FloatArray,
    propellers: FloatArray,
    ventilation: FloatArray,
    state: FloatArray,
    inputs: FloatArray,
    before: FloatArray,
    ventilates: bool,
    flowing: bool,
    time: float,
    dt: float,
) -> int:
    """Sail on from ``time`` by ``dt`` and return ``GOOD``; what ``first_bad`` finds is returned and nothing moves.

    Heun's method (explicit trapezoidal rule) on position and velocity through the water, between the forces at both
    ends of the step. The predictor tells the thrusters what the water around them is at the end; their force there
    begins the next step.

    Parameters
    ----------
    hull
        ``Hull.coefficients``.
    motion, outside
        Columns above; ``motion`` is changed.
    components, response, decay, thrusters
        The sea, what it does to the hull, and what is left of it at the shafts: see ``inflow``.
    parameters, propellers, ventilation, state
        Of the thrusters, see ``propulsion.PlantTables``; ``state`` is changed.
    inputs
        Shape (INPUTS, n): set points held over the step; the water at its end is written into it.
    before
        The inputs that were good last.
    ventilates, flowing
        False: nothing is lost to air; as without advance speed.
    time, dt
        s.
    """
    bad = first_bad(parameters, state, inputs, before, 0, ADVANCE_SPEED_INPUT)
    if bad != GOOD:
        return bad
    north, east, heading = motion[NORTH], motion[EAST], motion[HEADING]
    u, v, r = motion[SURGE], motion[SWAY], motion[YAW_RATE]
    current_north, current_east = outside[CURRENT_NORTH], outside[CURRENT_EAST]

    c, s = math.cos(heading), math.sin(heading)
    wx, wy, wn = drift_force(components, response, (north, east, heading), time)
    du, dv, dr = acceleration(
        hull,
        u,
        v,
        r,
        motion[THRUSTER_X] + outside[FORCE_X] + wx,
        motion[THRUSTER_Y] + outside[FORCE_Y] + wy,
        motion[THRUSTER_N] + outside[FORCE_N] + wn,
    )

    u2, v2, r2 = u + dt * du, v + dt * dv, r + dt * dr
    heading2 = heading + dt * r
    c2, s2 = math.cos(heading2), math.sin(heading2)
    place = (
        north + dt * (c * u - s * v + current_north),
        east + dt * (s * u + c * v + current_east),
        heading2,
    )
    fx, fy, fn = _thruster_force(
        components,
        response,
        decay,
        thrusters,
        parameters,
        propellers,
        ventilation,
        state,
        inputs,
        ventilates,
        flowing,
        place,
        (u2, v2, r2),
        (current_north, current_east),
        time + dt,
        dt,
    )
    wx, wy, wn = drift_force(components, response, place, time + dt)
    du2, dv2, dr2 = acceleration(
        hull, u2, v2, r2, fx + outside[FORCE_X] + wx, fy + outside[FORCE_Y] + wy, fn + outside[FORCE_N] + wn
    )

    half = 0.5 * dt
    motion[NORTH] = north + half * (c * u - s * v + c2 * u2 - s2 * v2) + dt * current_north
    motion[EAST] = east + half * (s * u + c * v + s2 * u2 + c2 * v2) + dt * current_east
    motion[HEADING] = heading + half * (r + r2)
    motion[SURGE] = u + half * (du + du2)
    motion[SWAY] = v + half * (dv + dv2)
    motion[YAW_RATE] = r + half * (dr + dr2)
    motion[THRUSTER_X], motion[THRUSTER_Y], motion[THRUSTER_N] = fx, fy, fn
    return GOOD


@compiled
def low_frequency(motion: FloatArray, outside: FloatArray) -> FloatArray:
    """Return low-frequency position (m, m, rad) and velocity over ground (body frame), shape (6,)."""
    found = np.empty(6)
    found[:3] = motion[:3]
    c, s = math.cos(motion[HEADING]), math.sin(motion[HEADING])
    current_north, current_east = outside[CURRENT_NORTH], outside[CURRENT_EAST]
    found[3] = motion[SURGE] + c * current_north + s * current_east
    found[4] = motion[SWAY] - s * current_north + c * current_east
    found[5] = motion[YAW_RATE]
    return found


@compiled
def seen(
    motion: FloatArray,
    outside: FloatArray,
    parameters: FloatArray,
    state: FloatArray,
    noise: FloatArray,
    speed_noise: float,
    azimuth_noise: float,
) -> tuple[FloatArray, FloatArray]:
    """Return what ``low_frequency`` and ``propulsion.readings.sensed`` do, in one call."""
    return low_frequency(motion, outside), sensed(parameters, state, noise, speed_noise, azimuth_noise)


@compiled
def _thruster_force(
    components: FloatArray,
    response: FloatArray,
    decay: FloatArray,
    thrusters: FloatArray,
    parameters: FloatArray,
    propellers: FloatArray,
    ventilation: FloatArray,
    state: FloatArray,
    inputs: FloatArray,
    ventilates: bool,
    flowing: bool,
    position: tuple[float, float, float],
    relative_velocity: tuple[float, float, float],
    current: tuple[float, float],
    time: float,
    dt: float,
) -> tuple[float, float, float]:
    """Advance the thrusters to ``time`` in the water where the hull will be, and return their force then.

    Azimuths at the end of the step are taken on at their present rate for the inflow: of first order, as the predictor
    of the hull that says where it will be.

    Returns
    -------
    Surge, sway and yaw, N, N, N m in the body frame, [Ruth] (4.11).
    """
    n = state.shape[0]
    azimuth = state[:, AZIMUTH] + dt * state[:, AZIMUTH_RATE]
    submergence, flow = inflow(
        components, response, decay, thrusters, position, relative_velocity, current, azimuth, time
    )
    for i in range(n):
        inputs[ADVANCE_SPEED_INPUT, i] = flow[i] if flowing else 0.0
        inputs[SUBMERGENCE_INPUT, i] = submergence[i]
    advance_rows(parameters, propellers, ventilation, state, inputs, ventilates, dt, 0, n)
    surge = sway = yaw = 0.0
    for i in range(n):
        fx = state[i, THRUST] * math.cos(state[i, AZIMUTH])
        fy = state[i, THRUST] * math.sin(state[i, AZIMUTH])
        surge += fx
        sway += fy
        yaw += thrusters[i, X] * fy - thrusters[i, Y] * fx
    return surge, sway, yaw
