"""Closed-form response of a second-order filter."""

from __future__ import annotations

import math
from typing import NamedTuple


class Transition(NamedTuple):
    """Matrix [[ee, er], [re, rr]] that carries (error, rate) over one step."""

    ee: float
    er: float
    re: float
    rr: float


def transition(frequency: float, damping: float, dt: float) -> Transition:
    """Return exp(A dt) of e'' + 2 damping frequency e' + frequency^2 e = 0.

    Parameters
    ----------
    frequency
        Undamped natural frequency, rad/s.
    damping
        Relative damping: below, at or above 1.
    dt
        Step, s.
    """
    decay = math.exp(-damping * frequency * dt)
    root = frequency * math.sqrt(abs(damping * damping - 1.0))
    if root * dt < 1e-6:
        # The two poles meet: cos -> 1 and sin(x)/x -> 1, exact to double precision here.
        c, s = 1.0, dt
    elif damping < 1.0:
        c, s = math.cos(root * dt), math.sin(root * dt) / root
    else:
        c, s = math.cosh(root * dt), math.sinh(root * dt) / root
    shift = damping * frequency * s
    return Transition(decay * (c + shift), decay * s, -frequency * frequency * decay * s, decay * (c - shift))
