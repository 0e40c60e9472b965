"""One feedback of all thrusters: detection, the memory of losses, and what is told of them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from marine_model.loss_memory import remembered
from thruster_drivers.ventilation.detection import detect
from thruster_drivers.ventilation.tables import (
    BETA,
    FLAG,
    KNOWN,
    REMEMBERED,
    SPEED,
    TOLD_BETA,
    TOLD_FLAG,
    TOLD_LOST,
    TOLD_REMEMBERED,
    TOLD_SPEED,
    TOLD_TORQUE,
)


@compiled
def watch(
    parameters: FloatArray,
    state: FloatArray,
    given: FloatArray,
    dt: float,
    sample_time: float,
    method: int,
    beta_column: int,
    on: float,
    off: float,
    relax_rate: float,
    events: NDArray[np.int64],
    told: FloatArray,
) -> None:
    """Advance ``state`` and count flags that go up in ``events``; write what is told into ``told``.

    Parameters
    ----------
    parameters, state, told
        Tables of :mod:`thruster_drivers.ventilation.tables`.
    given
        Shape (3, n): nominal load (N m/Hz^2), shaft speed (Hz), motor torque (N m), as :func:`detect` has them.
    dt, sample_time, method, on, off
        As :func:`detect` has them.
    beta_column
        Column of the state with the loss factor of the method.
    relax_rate
        1/s, of beta_Q2.
    events
        Shape (n,).
    """
    load = given[0]
    for j in range(state.shape[0]):
        told[TOLD_FLAG, j] = state[j, FLAG]
    detect(parameters, state, load, given[1], given[2], dt, sample_time, method, on, off)
    for j in range(state.shape[0]):
        flag, beta, speed = state[j, FLAG], state[j, beta_column], state[j, SPEED]
        if flag > told[TOLD_FLAG, j]:
            events[j] += 1
        state[j, REMEMBERED] = remembered(flag != 0.0, beta, state[j, REMEMBERED], relax_rate * dt)
        told[TOLD_FLAG, j] = flag
        told[TOLD_BETA, j] = beta
        told[TOLD_REMEMBERED, j] = state[j, REMEMBERED]
        lost = state[j, KNOWN] == 0.0
        told[TOLD_LOST, j] = 1.0 if lost else 0.0
        told[TOLD_SPEED, j] = math.nan if lost else speed
        told[TOLD_TORQUE, j] = 0.0 if lost else state[j, BETA] * load[j] * speed * abs(speed)
