"""Wind speed and force of the wind on a moving hull, compiled."""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from marine_model.wind import wind_force
from vessel_sim.wind.gusts import AMPLITUDE, FREQUENCY, PHASE

compiled_wind_force = compiled(wind_force)


@compiled
def speed_now(mean: float, gusts: FloatArray, time: float) -> float:
    """Return the wind speed (m/s) at ``time`` (s): the mean and the sum of all gust components."""
    speed = mean
    for i in range(len(gusts)):
        speed += gusts[i, AMPLITUDE] * math.cos(gusts[i, FREQUENCY] * time + gusts[i, PHASE])
    return speed


@compiled
def wind_load(
    constants: FloatArray,
    table: FloatArray,
    gusts: FloatArray,
    mean: float,
    direction: float,
    time: float,
    heading: float,
    u: float,
    v: float,
) -> tuple[float, float, float]:
    """Return the force of the wind (N, N, N m; body frame) at ``time`` (s) on a hull that moves.

    Parameters
    ----------
    constants, table
        Of the vessel's wind forces.
    gusts
        Components, shape (k, 3).
    mean
        Mean wind speed where the hull feels it, m/s.
    direction
        Direction in NED that the wind blows towards, rad.
    time
        s since the start.
    heading, u, v
        Heading (rad) and velocity over ground in the body frame (m/s).
    """
    speed = speed_now(mean, gusts, time)
    relative = direction - heading
    return compiled_wind_force(constants, table, u - speed * math.cos(relative), v - speed * math.sin(relative))
