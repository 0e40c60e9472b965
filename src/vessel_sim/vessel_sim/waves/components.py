"""Wave components as a table with a row for each, and the water at a point."""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

# Columns.
WAVE_NUMBER = 0  # k, rad/m
OMEGA = 1  # rad/s, seen from a fixed point
COS_BETA = 2
SIN_BETA = 3
AMPLITUDE = 4  # a, m
GROWTH = 5  # rate of change of the amplitude, m/s
PHASE = 6  # epsilon, rad
WIDTH = 7


@compiled
def phase(row: FloatArray, north: float, east: float, time: float) -> float:
    """Return theta of one component, rad."""
    theta: float = row[WAVE_NUMBER] * (north * row[COS_BETA] + east * row[SIN_BETA]) - row[OMEGA] * time + row[PHASE]
    return theta


@compiled
def elevation(components: FloatArray, north: float, east: float, time: float) -> float:
    """Return the elevation, m, positive up."""
    total = 0.0
    for i in range(components.shape[0]):
        total += components[i, AMPLITUDE] * math.cos(phase(components[i], north, east, time))
    return total


@compiled
def particle_velocity(
    components: FloatArray, north: float, east: float, depth: float, time: float
) -> tuple[float, float, float]:
    """Return the velocity of the water, m/s in NED: the rate of change of the particle displacement at a fixed point.

    Parameters
    ----------
    components
        The sea.
    north, east
        m.
    depth
        m below the calm surface. Above it the velocity of the surface is taken: linear theory ends there, and
        a propeller that lies higher has little water to meet, so that stretching (Wheeler) is not worth its cost.
    time
        s.
    """
    z = max(0.0, depth)
    vn = ve = vd = 0.0
    for i in range(components.shape[0]):
        row = components[i]
        theta = phase(row, north, east, time)
        decay = math.exp(-row[WAVE_NUMBER] * z)
        speed = row[AMPLITUDE] * row[OMEGA]
        sin_t, cos_t = math.sin(theta), math.cos(theta)
        along = decay * (speed * cos_t - row[GROWTH] * sin_t)
        vn += along * row[COS_BETA]
        ve += along * row[SIN_BETA]
        vd -= decay * (speed * sin_t + row[GROWTH] * cos_t)
    return vn, ve, vd
