"""Propeller torque from the torque balance of whole samples of the control system: the 5 Hz form, [Ruth] B.3.7.

(B.39) takes Q_p = Q_m - Q_f and leaves the torque out that changes the shaft speed. Slowing down from 10 Hz by 9 Hz/s,
which (B.43) lets pass, an aft thruster of CyberShip III would show beta_Q = 0.35 that way. Over samples from t_0 to t_1

    beta_Q = (integral(Q_m - Q_f) dt - 2 pi J (n(t_1) - n(t_0))) / integral(Q_nom) dt

holds exactly, however torque and speed moved in between; at steady speed it is (B.39)-(B.40). Noise sigma in either
shaft speed puts sqrt(2) 2 pi J sigma over the nominal impulse into beta_Q. The window is the shortest whole number of
samples whose nominal impulse keeps that below what is allowed. Where four samples are not enough, near n = 0, or the
shaft has turned the other way in the window, beta_Q is 1: the parts of both ways would cancel in the nominal impulse,
while what the advance speed does to the torque would not.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thruster_drivers.ventilation.tables import (
    BETA_SAMPLED,
    ELAPSED,
    IMPULSE,
    INERTIA,
    LAST_SPEED,
    NOISE_SAMPLED,
    NOMINAL,
    RATE,
    RING,
    RING_WIDTH,
    START,
    WINDOW,
)
from thruster_drivers.ventilation.torque_observer import BETA_MAX, BETA_MIN, friction

_NONE = 1e-300  # N m s; keeps 0/0 out where a vessel has no noise


@compiled
def balance(
    parameters: FloatArray, state: FloatArray, load: float, speed: float, torque: float, dt: float, sample_time: float
) -> bool:
    """Add one feedback to the balance of one thruster; return True where a sample ends and beta_Q is new.

    Parameters
    ----------
    parameters, state
        Rows of the tables; ``state`` is changed.
    load
        c = K_Q0(P/D) rho D^5, N m/Hz^2.
    speed, torque
        Shaft speed now (Hz) and motor torque of the step that ended now (N m).
    dt
        s, length of that step.
    sample_time
        s, of the control system.
    """
    last = state[LAST_SPEED]
    state[LAST_SPEED] = speed
    state[ELAPSED] += dt
    state[IMPULSE] += (torque - friction(parameters, 0.5 * (last + speed), torque)) * dt
    state[NOMINAL] += 0.5 * load * (last * abs(last) + speed * abs(speed)) * dt
    if state[ELAPSED] < sample_time - 0.5 * dt:
        return False
    for k in range(RING_WIDTH * WINDOW - 1, RING_WIDTH - 1, -1):
        state[RING + k] = state[RING + k - RING_WIDTH]
    state[RING], state[RING + 1], state[RING + 2] = state[IMPULSE], state[NOMINAL], state[START]
    state[RATE] = (speed - state[START]) / state[ELAPSED]
    state[START] = speed
    state[ELAPSED] = state[IMPULSE] = state[NOMINAL] = 0.0

    needed = max(math.sqrt(2.0) * parameters[INERTIA] * parameters[NOISE_SAMPLED], _NONE)
    impulse = nominal = 0.0
    state[BETA_SAMPLED] = 1.0
    for k in range(WINDOW):
        at = RING + k * RING_WIDTH
        if state[at + 2] * speed < 0.0:
            break
        impulse += state[at]
        nominal += state[at + 1]
        if abs(nominal) >= needed:
            beta = (impulse - parameters[INERTIA] * (speed - state[at + 2])) / nominal
            state[BETA_SAMPLED] = max(BETA_MIN, min(BETA_MAX, beta))
            break
    return True
