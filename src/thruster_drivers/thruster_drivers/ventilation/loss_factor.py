"""Torque loss factor, [Ruth] (B.40), and how much noise it may have."""

from __future__ import annotations

import math


def allowed_noise(on: float, off: float, interval: float, dt: float) -> float:
    """Return the standard deviation that beta_Q may have from noise of the sensors.

    A propeller counts as wet above ``off``, so noise has to cross off - on to raise a false alarm. Gaussian noise with
    at most one independent value a step of ``dt`` does that once in ``interval`` on average, [Rice 1944], if

        (off - on) / s = sqrt(2 ln(interval / dt)).

    Ten times the interval changes s by 6 % (from 1000 h at 50 Hz).

    Parameters
    ----------
    on, off
        Thresholds of (5.14) and (5.15).
    interval
        s between false alarms.
    dt
        s between values.
    """
    return (off - on) / math.sqrt(2.0 * math.log(interval / dt))
