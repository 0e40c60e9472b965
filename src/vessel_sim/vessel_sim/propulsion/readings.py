"""What the sensors show of the state of the propulsion plant, compiled."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from vessel_sim.propulsion.columns import (
    AZIMUTH,
    AZIMUTH_RATE,
    MOTOR_TORQUE,
    PITCH_RATIO,
    SHAFT_SPEED,
    TURNS,
)

_TWO_PI = 2.0 * math.pi

# Rows of ``sensed``.
SHAFT_SPEED_ROW, TORQUE_ROW, POWER_ROW, AZIMUTH_ROW, AZIMUTH_RATE_ROW, PITCH_ROW, READINGS = range(7)


@compiled
def sensed(
    parameters: np.ndarray, state: np.ndarray, noise: np.ndarray, speed_noise: float, azimuth_noise: float
) -> np.ndarray:
    """Return what the thruster sensors show, shape (READINGS, n).

    Power is what the motor develops by the measured shaft speed, 2 pi n Q, [Ruth] (B.3). Angles are in [-pi, pi).

    Parameters
    ----------
    parameters, state
        Shapes (n, PARAMETERS), (n, STATE).
    noise
        Standard normal numbers, shape (2 n,): shaft speeds, then azimuths. A thruster that does not turn has no
        angle to measure.
    speed_noise, azimuth_noise
        Standard deviations, Hz and rad.
    """
    n = state.shape[0]
    readings = np.empty((READINGS, n))
    for i in range(n):
        speed = state[i, SHAFT_SPEED] + speed_noise * noise[i]
        angle = state[i, AZIMUTH]
        if parameters[i, TURNS] != 0.0:
            angle += azimuth_noise * noise[n + i]
        angle = (angle + math.pi) % _TWO_PI - math.pi
        readings[SHAFT_SPEED_ROW, i] = speed
        readings[TORQUE_ROW, i] = state[i, MOTOR_TORQUE]
        readings[POWER_ROW, i] = _TWO_PI * speed * state[i, MOTOR_TORQUE]
        # The sum rounds up to exactly 2 pi for tiny negative remainders.
        readings[AZIMUTH_ROW, i] = angle if angle < math.pi else -math.pi
        readings[AZIMUTH_RATE_ROW, i] = state[i, AZIMUTH_RATE]
        readings[PITCH_ROW, i] = state[i, PITCH_RATIO]
    return readings
