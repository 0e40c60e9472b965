"""Pitch actuator of one controllable-pitch propeller: a first-order lag with a rate limit, solved in closed form."""

from __future__ import annotations

import math

from marine_model.compiled import inlined


@inlined
def advance(
    pitch: float, demand: float, low: float, high: float, rate_max: float, time_constant: float, dt: float
) -> float:
    """Return the pitch ratio after ``dt``.

    p_dot = clamp((clamp(p_d) - p) / T, -rate, rate), exact for a demand p_d held over the step: the blades turn at the
    rate limit until the error is rate T, and close in on the demand from there.

    Parameters
    ----------
    pitch
        p at the start.
    demand
        p_d; what is outside ``low`` to ``high`` counts as the nearer of them.
    low, high
        Range of the actuator.
    rate_max
        1/s, above 0.
    time_constant
        T, s, above 0.
    dt
        s.
    """
    demand = min(max(demand, low), high)
    error = demand - pitch
    if error == 0.0:
        return demand
    near = rate_max * time_constant
    travel = abs(error) - near
    if travel > 0.0:
        saturated = travel / rate_max
        if saturated >= dt:
            return pitch + math.copysign(rate_max * dt, error)
        error = math.copysign(near, error)
        dt -= saturated
    return demand - error * math.exp(-dt / time_constant)
