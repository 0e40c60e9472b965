"""One step of a submerged vehicle, compiled: body, water at the thrusters, thrusters."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from vessel_sim.propulsion.columns import (
    ADVANCE_SPEED_INPUT,
    AZIMUTH,
    AZIMUTH_RATE,
    SUBMERGENCE_INPUT,
    THRUST,
)
from vessel_sim.propulsion.step import GOOD, advance_rows, first_bad
from vessel_sim.underwater.body import down_in_body, rate_of_change
from vessel_sim.underwater.columns import (
    DEPTH,
    HEADING,
    MOTION,
    QUATERNION,
    RIGID,
    THRUSTERS,
    VELOCITY,
)


@compiled
def dive(
    body: FloatArray,
    motion: FloatArray,
    current: tuple[float, float],
    position: FloatArray,
    wrench: FloatArray,
    parameters: FloatArray,
    propellers: FloatArray,
    ventilation: FloatArray,
    state: FloatArray,
    inputs: FloatArray,
    before: FloatArray,
    ventilates: bool,
    flowing: bool,
    dt: float,
) -> int:
    """Go on by ``dt`` and return ``GOOD``; what ``first_bad`` finds is returned and nothing moves.

    The thrusters go first, to the end of the step, in the water where Euler's method says that the body will be; then
    the body, see ``move``. Order 4 while the thrusters' force stays, 2 with it; the energy of a swing never grows.

    Parameters
    ----------
    body
        ``SubmergedBody.coefficients``.
    motion
        See ``columns``; is changed.
    current
        North, east, m/s.
    position
        Of the thrusters, m, body frame, shape (n, 3).
    wrench
        Force in six degrees of freedom for a newton of every thruster along n_1 and n_2, shape (n, 6, 2).
    parameters, propellers, ventilation, state
        Of the thrusters, see ``propulsion.PlantTables``; ``state`` is changed.
    inputs
        Shape (INPUTS, n): set points held over the step; the water at its end is written into it.
    before
        The inputs that were good last.
    ventilates, flowing
        False: nothing is lost to air; as without advance speed.
    dt
        s.
    """
    bad = first_bad(parameters, state, inputs, before, 0, ADVANCE_SPEED_INPUT)
    if bad != GOOD:
        return bad
    n = state.shape[0]
    force = motion[THRUSTERS : THRUSTERS + 6].copy()
    at, rate = np.empty(MOTION), np.empty(RIGID)
    rate_of_change(body, motion, force, current, rate)
    for i in range(RIGID):
        at[i] = motion[i] + dt * rate[i]
    azimuth = state[:, AZIMUTH] + dt * state[:, AZIMUTH_RATE]
    submergence, flow = water_at(at, position, wrench, azimuth)
    for i in range(n):
        inputs[ADVANCE_SPEED_INPUT, i] = flow[i] if flowing else 0.0
        inputs[SUBMERGENCE_INPUT, i] = submergence[i]
    advance_rows(parameters, propellers, ventilation, state, inputs, ventilates, dt, 0, n)
    motion[THRUSTERS : THRUSTERS + 6] = thruster_force(wrench, state)
    move(body, motion, force, current, dt)
    return GOOD


@compiled
def move(body: FloatArray, motion: FloatArray, force: FloatArray, current: tuple[float, float], dt: float) -> None:
    """Move the body on by ``dt`` (s): the classical Runge-Kutta method.

    Parameters
    ----------
    body, current, dt
        See ``dive``.
    motion
        See ``columns``; is changed, but for the force of the thrusters, which is that at the end of the step.
    force
        That at its start, shape (6,); it goes straight from one to the other.
    """
    start, end = motion[:RIGID].copy(), motion[THRUSTERS : THRUSTERS + 6].copy()
    middle = 0.5 * (force + end)
    heading = heading_of(motion)
    at, rate, total = np.empty(RIGID), np.empty(RIGID), np.empty(RIGID)
    rate_of_change(body, start, force, current, rate)
    for i in range(RIGID):
        total[i] = rate[i]
    for stage in range(3):
        last = stage == 2
        for i in range(RIGID):
            at[i] = start[i] + (dt if last else 0.5 * dt) * rate[i]
        rate_of_change(body, at, end if last else middle, current, rate)
        for i in range(RIGID):
            total[i] += (1.0 if last else 2.0) * rate[i]
    for i in range(RIGID):
        motion[i] = start[i] + dt / 6.0 * total[i]
    length = 0.0
    for i in range(QUATERNION, QUATERNION + 4):
        length += motion[i] * motion[i]
    for i in range(QUATERNION, QUATERNION + 4):
        motion[i] /= math.sqrt(length)
    turned = (heading_of(motion) - heading) / (2.0 * math.pi)
    motion[HEADING] += 2.0 * math.pi * (turned - math.floor(turned + 0.5))


@compiled
def heading_of(motion: FloatArray) -> float:
    """Return the heading, rad in [-pi, pi]."""
    w, x, y, z = motion[QUATERNION], motion[QUATERNION + 1], motion[QUATERNION + 2], motion[QUATERNION + 3]
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


@compiled
def water_at(
    motion: FloatArray, position: FloatArray, wrench: FloatArray, azimuth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return submergence (m, below the calm surface) and speed of advance (m/s) of the thrusters, shape (n,) each.

    The speed of advance is the velocity of the thruster through the water along its thrust: with b the column of
    [Ruth] (4.3) for the direction of its thrust, b^T nu_r = direction . (v + w x r).
    """
    n = position.shape[0]
    x, y, z = down_in_body(motion)
    submergence, advance = np.empty(n), np.empty(n)
    for j in range(n):
        submergence[j] = motion[DEPTH] + x * position[j, 0] + y * position[j, 1] + z * position[j, 2]
        c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
        along = 0.0
        for i in range(6):
            along += (wrench[j, i, 0] * c + wrench[j, i, 1] * s) * motion[VELOCITY + i]
        advance[j] = along
    return submergence, advance


@compiled
def thruster_force(wrench: FloatArray, state: FloatArray) -> FloatArray:
    """Return the force of all thrusters in six degrees of freedom, shape (6,), N and N m: [Ruth] (4.3)."""
    force = np.zeros(6)
    for j in range(state.shape[0]):
        along = state[j, THRUST] * math.cos(state[j, AZIMUTH])
        across = state[j, THRUST] * math.sin(state[j, AZIMUTH])
        for i in range(6):
            force[i] += wrench[j, i, 0] * along + wrench[j, i, 1] * across
    return force
