"""Advance speed of propellers in water without waves."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from vessel_sim.propulsion.columns import AZIMUTH, AZIMUTH_RATE


@compiled
def advance_speed(
    state: np.ndarray, lever_x: np.ndarray, lever_y: np.ndarray, u: float, v: float, r: float, ahead: float
) -> np.ndarray:
    """Return V_A, m/s, shape (n,): speed through the water of each propeller along its positive thrust.

    (u - L_y r) cos alpha + (v + L_x r) sin alpha, with alpha ``ahead`` s on at the present rate of turn.

    Parameters
    ----------
    state
        Shape (n, STATE).
    lever_x, lever_y
        L_x, L_y, m, shape (n,).
    u, v, r
        Velocity through the water in the body frame, m/s, m/s, rad/s.
    ahead
        s.
    """
    flow = np.empty(state.shape[0])
    for i in range(state.shape[0]):
        angle = state[i, AZIMUTH] + ahead * state[i, AZIMUTH_RATE]
        flow[i] = (u - lever_y[i] * r) * math.cos(angle) + (v + lever_x[i] * r) * math.sin(angle)
    return flow
