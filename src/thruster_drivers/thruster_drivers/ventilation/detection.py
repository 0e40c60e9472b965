"""Ventilation flag with hysteresis, [Ruth] (5.14)-(5.15) and, at the control system's rate, (B.41)-(B.44)."""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thruster_drivers.ventilation.sampled_balance import balance
from thruster_drivers.ventilation.tables import (
    BETA,
    BETA_SAMPLED,
    DECELERATION_LIMIT,
    ELAPSED,
    EXCLUDED,
    FLAG,
    IMPULSE,
    KNOWN,
    LAST_SPEED,
    NOMINAL,
    RATE,
    RING,
    RING_WIDTH,
    SPEED,
    SPEED_MIN,
    START,
    TORQUE_RATE_LIMIT,
    TORQUE_RATE_TIME,
    TORQUE_SLOW,
    WINDOW,
)
from thruster_drivers.ventilation.torque_observer import observe

TORQUE_RATE = 0
SHAFT_DECELERATION = 1


@compiled
def torque_rate(parameters: FloatArray, state: FloatArray, torque: float, dt: float) -> float:
    """Return dQ_m/dt, N m/s, of one thruster: the backward difference over an exponential window."""
    time = parameters[TORQUE_RATE_TIME]
    state[TORQUE_SLOW] += (1.0 - math.exp(-dt / time)) * (torque - state[TORQUE_SLOW])
    return float((torque - state[TORQUE_SLOW]) / time)


@compiled
def begin(state: FloatArray, speed: float, torque: float) -> None:
    """Start one thruster at what is measured, without loss and without a past."""
    state[KNOWN] = 1.0
    state[SPEED] = state[LAST_SPEED] = state[START] = speed
    state[BETA] = state[BETA_SAMPLED] = 1.0
    state[TORQUE_SLOW] = torque
    state[FLAG] = state[ELAPSED] = state[IMPULSE] = state[NOMINAL] = state[RATE] = 0.0
    for k in range(WINDOW * RING_WIDTH):
        state[RING + k] = 0.0


@compiled
def lose(state: FloatArray) -> None:
    """Forget one thruster whose sensor is lost: no loss is claimed and none is flagged."""
    state[KNOWN] = state[FLAG] = 0.0
    state[BETA] = state[BETA_SAMPLED] = 1.0


@compiled
def detect(
    parameters: FloatArray,
    state: FloatArray,
    load: FloatArray,
    speed: FloatArray,
    torque: FloatArray,
    dt: float,
    sample_time: float,
    method: int,
    on: float,
    off: float,
) -> None:
    """Advance observers and flags of all thrusters by one feedback; ``state`` is changed.

    The flag goes up where all conditions of the method hold, goes down above ``off``, and is held in between.

    ``TORQUE_RATE``, at every feedback: beta_Q < on, sign(Q_m) dQ_m/dt < limit, |n| > n_min (5.14).

    ``SHAFT_DECELERATION``, at every sample of the control system: |n| > n_lim, beta_Q < on, sign(n) dn/dt > -limit,
    (B.41)-(B.43). (B.43) prints dn/dt > -10, which is a reduction for n > 0 only.

    Parameters
    ----------
    parameters, state
        Tables, a row for each thruster.
    load
        Shape (n,): c = K_Q0(P/D) rho D^5, N m/Hz^2.
    speed, torque
        Shape (n,): shaft speed now (Hz), motor torque of the step that ended now (N m). NaN or infinite: sensor lost.
    dt
        s, length of that step.
    sample_time
        s, of the control system.
    method
        ``TORQUE_RATE`` or ``SHAFT_DECELERATION``.
    on, off
        Thresholds of beta_Q.
    """
    patience = WINDOW * sample_time
    for j in range(state.shape[0]):
        row, memory = parameters[j], state[j]
        n, q = speed[j], torque[j]
        if not math.isfinite(n + q):
            lose(memory)
            continue
        if memory[KNOWN] == 0.0:
            begin(memory, n, q)
            continue
        observe(row, memory, load[j], n, q, dt, patience)
        rate = torque_rate(row, memory, q, dt)
        sampled = balance(row, memory, load[j], n, q, dt, sample_time)
        if method == TORQUE_RATE:
            beta = memory[BETA]
            # The observed speed: at the measured one, noise would decide near n_min.
            start = abs(memory[SPEED]) > row[SPEED_MIN] and math.copysign(1.0, q) * rate < row[TORQUE_RATE_LIMIT]
        else:
            beta = memory[BETA_SAMPLED]
            # At both ends of the last sample: the balance is a mean over it.
            start = sampled and min(abs(n), abs(memory[RING + 2])) > row[SPEED_MIN]
            start = start and math.copysign(1.0, n) * memory[RATE] > -row[DECELERATION_LIMIT]
        if row[EXCLUDED] != 0.0 or beta > off:
            memory[FLAG] = 0.0
        elif start and beta < on:
            memory[FLAG] = 1.0
