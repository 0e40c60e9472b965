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


def least_speed(on: float, torque_slope: float, advance_speed: float, diameter: float) -> float:
    """Return the n_min (Hz) above which the advance speed alone does not take beta_Q below ``on``.

    From K_Q = K_Q0 + a_Q V_A / (n D), [Ruth] (3.7): n = |a_Q / K_Q0| V_A / ((1 - on) D).

    Parameters
    ----------
    on
        Threshold of (5.14).
    torque_slope
        a_Q / K_Q0.
    advance_speed
        Largest V_A, m/s.
    diameter
        D, m.
    """
    return abs(torque_slope) * advance_speed / ((1.0 - on) * diameter)
