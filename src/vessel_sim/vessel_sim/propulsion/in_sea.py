"""The step of the propulsion plant under a hull in waves and current: inflow, thrusters and their force in one call."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from vessel_sim.inflow import X, Y, inflow
from vessel_sim.propulsion.columns import (
    ADVANCE_SPEED_INPUT,
    AZIMUTH,
    AZIMUTH_RATE,
    INPUTS,
    SUBMERGENCE_INPUT,
    THRUST,
)
from vessel_sim.propulsion.step import advance
from vessel_sim.waves.hull_form import Triple


@compiled
def advance_in_sea(
    parameters: np.ndarray,
    propellers: np.ndarray,
    ventilation: np.ndarray,
    state: np.ndarray,
    inputs: np.ndarray,
    ventilates: bool,
    flowing: bool,
    components: np.ndarray,
    box: Triple,
    thrusters: np.ndarray,
    position: Triple,
    relative_velocity: Triple,
    current: tuple[float, float],
    time: float,
    dt: float,
) -> Triple:
    """Advance ``state`` by ``dt`` (s) to ``time`` and return the force of all thrusters then.

    Azimuths at the end of the step are taken on at their present rate for the inflow: of first order, as the predictor
    of the hull that says where it will be. For the arguments see ``step.advance`` and ``inflow``.

    Returns
    -------
    Surge, sway and yaw, N, N, N m in the body frame, [Ruth] (4.11).
    """
    n = state.shape[0]
    azimuth = np.empty(n)
    for i in range(n):
        azimuth[i] = state[i, AZIMUTH] + dt * state[i, AZIMUTH_RATE]
    submergence, flow = inflow(components, box, thrusters, position, relative_velocity, current, azimuth, time)
    for i in range(n):
        inputs[ADVANCE_SPEED_INPUT, i] = flow[i] if flowing else 0.0
        inputs[SUBMERGENCE_INPUT, i] = submergence[i]
    advance(parameters, propellers, ventilation, state, inputs, inputs, INPUTS, ventilates, dt)
    surge = sway = yaw = 0.0
    for i in range(n):
        fx = state[i, THRUST] * math.cos(state[i, AZIMUTH])
        fy = state[i, THRUST] * math.sin(state[i, AZIMUTH])
        surge += fx
        sway += fy
        yaw += thrusters[i, X] * fy - thrusters[i, Y] * fx
    return surge, sway, yaw
