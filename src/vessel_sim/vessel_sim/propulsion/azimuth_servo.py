"""Azimuth motor of one thruster: a rate servo with a first-order lag and a rate limit, solved in closed form."""

from __future__ import annotations

import math

from marine_model.compiled import inlined


@inlined
def settled_share(time_constant: float, dt: float) -> float:
    """Return 1 - exp(-dt / T), the share of an error of the rate that is gone after ``dt``."""
    return -math.expm1(-dt / time_constant)


@inlined
def advance(
    angle: float, rate: float, demand: float, rate_max: float, time_constant: float, settled: float, dt: float
) -> tuple[float, float]:
    """Return angle (rad, not wrapped) and rate (rad/s) after ``dt``.

    w_dot = (clamp(w_d) - w) / T, alpha_dot = w, exact for a demand w_d held over the step.

    Parameters
    ----------
    angle, rate
        alpha, rad, and w, rad/s, at the start.
    demand
        w_d, rad/s.
    rate_max
        Limit of the demand either way, and so of the rate, rad/s.
    time_constant
        T, s, above 0.
    settled
        ``settled_share``: the same for all steps of one length.
    dt
        s.
    """
    demand = min(max(demand, -rate_max), rate_max)
    excess = rate - demand
    return angle + demand * dt + excess * settled * time_constant, demand + excess * (1.0 - settled)
