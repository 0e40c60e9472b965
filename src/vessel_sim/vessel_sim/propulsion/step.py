"""One time step of all thrusters, compiled: actuators and shafts in closed form, propellers with their losses."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled, unlocked
from marine_model.propellers.kernel import load, thrust_torque
from marine_model.ventilation.dynamic import limited_rise
from marine_model.ventilation.static import loss_factors
from marine_model.ventilation.table import THRUST_RISE_RATE, TORQUE_RISE_RATE
from vessel_sim.propulsion import azimuth_servo, pitch_servo, shaft
from vessel_sim.propulsion.columns import (
    ADVANCE_SPEED,
    ADVANCE_SPEED_INPUT,
    AZIMUTH,
    AZIMUTH_RATE,
    AZIMUTH_RATE_INPUT,
    AZIMUTH_RATE_MAX,
    AZIMUTH_SETTLED,
    AZIMUTH_TIME_CONSTANT,
    CONTROLLABLE,
    DENSITY,
    DIAMETER,
    INERTIA,
    INPUTS,
    MOTOR_TORQUE,
    PITCH_INPUT,
    PITCH_MAX,
    PITCH_MIN,
    PITCH_RATE_MAX,
    PITCH_RATIO,
    PITCH_TIME_CONSTANT,
    PROPELLER,
    PROPELLER_TORQUE,
    SHAFT_SPEED,
    STATIC,
    STEP,
    SUBMERGENCE,
    SUBMERGENCE_INPUT,
    THRUST,
    THRUST_LOSS,
    THRUST_WETTED,
    TORQUE_INPUT,
    TORQUE_LOSS,
    TORQUE_MAX,
    TORQUE_WETTED,
    TURNS,
    VENTILATION,
    VISCOUS,
)

GOOD = -1


@compiled
def first_bad(
    parameters: np.ndarray, state: np.ndarray, inputs: np.ndarray, before: np.ndarray, first: int, end: int
) -> int:
    """Return row times n plus column of the first input in rows ``first`` to ``end`` - 1 that cannot be taken.

    That is a number that is not finite, or another pitch than its own for a propeller of fixed pitch; ``GOOD`` if
    there is none. ``before`` are the inputs that were good last.
    """
    n: int = inputs.shape[1]
    bad = False
    for j in range(first, end):  # without a way out, so that several numbers are looked at at once
        for i in range(n):
            bad |= not abs(inputs[j, i]) < math.inf
    if first <= PITCH_INPUT < end:
        for i in range(n):
            if inputs[PITCH_INPUT, i] != before[PITCH_INPUT, i]:  # few: tables are read for those alone
                bad |= parameters[i, CONTROLLABLE] == 0.0
    if not bad:
        return GOOD
    for j in range(first, end):
        for i in range(n):
            if not math.isfinite(inputs[j, i]):
                return j * n + i
            if j == PITCH_INPUT and parameters[i, CONTROLLABLE] == 0.0 and inputs[j, i] != state[i, PITCH_RATIO]:
                return j * n + i
    return GOOD


@compiled
def advance(
    parameters: np.ndarray,
    propellers: np.ndarray,
    ventilation: np.ndarray,
    state: np.ndarray,
    inputs: np.ndarray,
    before: np.ndarray,
    unchecked: int,
    ventilates: bool,
    dt: float,
) -> int:
    """Advance ``state`` by ``dt`` (s) and return ``GOOD``; what ``first_bad`` finds is returned and nothing moves.

    The load of a shaft is held over the step. Advance speed, submergence and pitch are taken in the middle of the
    step, the mean of both ends, and the load is the tangent at the shaft speed of the start: order 2.

    Parameters
    ----------
    parameters, propellers, ventilation, state
        See ``PlantTables``; ``state`` is changed.
    inputs
        Shape (INPUTS, n): set points held over the step, and the water at its end.
    before
        The inputs that were good last.
    unchecked
        First row of ``inputs`` to look at with ``first_bad``.
    ventilates
        False where propellers lose nothing to air.
    dt
        s, at least 0.
    """
    bad = first_bad(parameters, state, inputs, before, unchecked, INPUTS)
    if bad == GOOD:
        advance_rows(parameters, propellers, ventilation, state, inputs, ventilates, dt, 0, state.shape[0])
    return bad


@compiled
def advance_rows(
    parameters: np.ndarray,
    propellers: np.ndarray,
    ventilation: np.ndarray,
    state: np.ndarray,
    inputs: np.ndarray,
    ventilates: bool,
    dt: float,
    first: int,
    end: int,
) -> None:
    """Advance rows ``first`` to ``end`` - 1 of ``state``; see ``advance``. ``inputs`` are good."""
    for i in range(first, end):
        row = propellers[int(parameters[i, PROPELLER])]
        diameter, density = parameters[i, DIAMETER], parameters[i, DENSITY]
        limit = parameters[i, TORQUE_MAX]
        torque = min(max(inputs[TORQUE_INPUT, i], -limit), limit)

        if parameters[i, TURNS] != 0.0:
            if state[i, STEP] != dt:
                state[i, STEP] = dt
                state[i, AZIMUTH_SETTLED] = azimuth_servo.settled_share(parameters[i, AZIMUTH_TIME_CONSTANT], dt)
            state[i, AZIMUTH], state[i, AZIMUTH_RATE] = azimuth_servo.advance(
                state[i, AZIMUTH],
                state[i, AZIMUTH_RATE],
                inputs[AZIMUTH_RATE_INPUT, i],
                parameters[i, AZIMUTH_RATE_MAX],
                parameters[i, AZIMUTH_TIME_CONSTANT],
                state[i, AZIMUTH_SETTLED],
                dt,
            )
        pitch_before = pitch = state[i, PITCH_RATIO]
        if parameters[i, CONTROLLABLE] != 0.0:
            pitch = pitch_servo.advance(
                pitch,
                inputs[PITCH_INPUT, i],
                parameters[i, PITCH_MIN],
                parameters[i, PITCH_MAX],
                parameters[i, PITCH_RATE_MAX],
                parameters[i, PITCH_TIME_CONSTANT],
                dt,
            )
        middle = 0.5 * (pitch_before + pitch)

        speed = state[i, SHAFT_SPEED]
        flow = inputs[ADVANCE_SPEED_INPUT, i]
        depth = inputs[SUBMERGENCE_INPUT, i]
        kind = int(parameters[i, VENTILATION])
        airy = ventilates and kind >= 0
        remains = 1.0
        if airy:
            area, _, wetted = loss_factors(
                ventilation[kind], speed, diameter, middle, (state[i, SUBMERGENCE] + depth) / diameter
            )
            rise = ventilation[kind, TORQUE_RISE_RATE]
            remains = area * limited_rise(wetted, state[i, TORQUE_WETTED], rise, 0.5 * dt)
        c, a, b = load(row, diameter, density, speed, 0.5 * (state[i, ADVANCE_SPEED] + flow), middle)
        speed = shaft.advance(
            speed,
            torque - remains * b,
            parameters[i, INERTIA],
            remains * c,
            remains * a,
            parameters[i, VISCOUS],
            parameters[i, STATIC],
            dt,
        )

        area = thrust_wetted = torque_wetted = 1.0
        if airy:
            area, thrust_wetted, torque_wetted = loss_factors(
                ventilation[kind], speed, diameter, pitch, 2.0 * depth / diameter
            )
            thrust_wetted = limited_rise(
                thrust_wetted, state[i, THRUST_WETTED], ventilation[kind, THRUST_RISE_RATE], dt
            )
            torque_wetted = limited_rise(
                torque_wetted, state[i, TORQUE_WETTED], ventilation[kind, TORQUE_RISE_RATE], dt
            )
        thrust, propeller_torque = thrust_torque(row, diameter, density, speed, flow, pitch)

        state[i, SHAFT_SPEED] = speed
        state[i, PITCH_RATIO] = pitch
        state[i, THRUST_WETTED] = thrust_wetted
        state[i, TORQUE_WETTED] = torque_wetted
        state[i, MOTOR_TORQUE] = torque
        state[i, THRUST_LOSS] = area * thrust_wetted
        state[i, TORQUE_LOSS] = area * torque_wetted
        state[i, THRUST] = area * thrust_wetted * thrust
        state[i, PROPELLER_TORQUE] = area * torque_wetted * propeller_torque
        state[i, ADVANCE_SPEED] = flow
        state[i, SUBMERGENCE] = depth


@unlocked
def advance_rows_unlocked(
    parameters: np.ndarray,
    propellers: np.ndarray,
    ventilation: np.ndarray,
    state: np.ndarray,
    inputs: np.ndarray,
    ventilates: bool,
    dt: float,
    first: int,
    end: int,
) -> None:
    """Do what ``advance_rows`` does, beside other threads."""
    advance_rows(parameters, propellers, ventilation, state, inputs, ventilates, dt, first, end)
