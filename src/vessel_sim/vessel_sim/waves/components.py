"""Wave components as a table with a row for each, and the water at a point.

The amplitude of a row is a step that travels: with s = north cos(beta) + east sin(beta) and the group velocity
c_g = g / (2 omega),

    a(s, t) = A clamp((t - s / c_g - start) / ramp, 0, 1).

The envelope of a narrow-banded linear wave group travels so in deep water; that the front also spreads is left out.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled, inlined
from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray

# Columns.
WAVE_NUMBER = 0  # k, rad/m
OMEGA = 1  # rad/s, seen from a fixed point
COS_BETA = 2
SIN_BETA = 3
AMPLITUDE = 4  # A, m, once the front has passed; negative where a step takes away
PHASE = 5  # epsilon, rad
BETA = 6  # direction of travel in NED, rad
START = 7  # s, when the front passes the map origin; -inf where it passed long ago
RAMP = 8  # s from nothing to A
SLOWNESS = 9  # 1 / c_g, s/m; 0 where the step comes everywhere at once
WIDTH = 10


def component_table(omega: FloatArray, direction: ArrayLike, amplitude: ArrayLike, phase: ArrayLike) -> FloatArray:
    """Return components without fronts in deep water, shape (m, WIDTH).

    Parameters
    ----------
    omega
        rad/s, shape (m,).
    direction
        Direction of travel in NED, rad, shape (m,) or a number.
    amplitude, phase
        m, rad, shape (m,) or a number.
    """
    table = np.zeros((omega.size, WIDTH))
    table[:, OMEGA] = omega
    table[:, WAVE_NUMBER] = omega**2 / GRAVITY
    table[:, SLOWNESS] = 2.0 * omega / GRAVITY
    table[:, BETA] = direction
    table[:, COS_BETA] = np.cos(table[:, BETA])
    table[:, SIN_BETA] = np.sin(table[:, BETA])
    table[:, AMPLITUDE] = amplitude
    table[:, PHASE] = phase
    table[:, START] = -np.inf
    return table


@inlined
def local_amplitude(components: FloatArray, i: int, along: float, time: float) -> tuple[float, float]:
    """Return amplitude (m) and its rate of change at a fixed point (m/s) of row ``i``; ``along`` is s."""
    since = time - along * components[i, SLOWNESS] - components[i, START]
    ramp = components[i, RAMP]
    if since >= ramp:
        return components[i, AMPLITUDE], 0.0
    if since <= 0.0:
        return 0.0, 0.0
    growth = components[i, AMPLITUDE] / ramp
    return growth * since, growth


@compiled
def elevation(components: FloatArray, north: float, east: float, time: float) -> float:
    """Return the elevation, m, positive up."""
    total = 0.0
    for i in range(components.shape[0]):
        along = north * components[i, COS_BETA] + east * components[i, SIN_BETA]
        a, _ = local_amplitude(components, i, along, time)
        total += a * math.cos(components[i, WAVE_NUMBER] * along - components[i, OMEGA] * time + components[i, PHASE])
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
        k = components[i, WAVE_NUMBER]
        along = north * components[i, COS_BETA] + east * components[i, SIN_BETA]
        theta = k * along - components[i, OMEGA] * time + components[i, PHASE]
        a, growth = local_amplitude(components, i, along, time)
        decay = math.exp(-k * z)
        speed = a * components[i, OMEGA]
        sin_t, cos_t = math.sin(theta), math.cos(theta)
        forward = decay * (speed * cos_t - growth * sin_t)
        vn += forward * components[i, COS_BETA]
        ve += forward * components[i, SIN_BETA]
        vd -= decay * (speed * sin_t + growth * cos_t)
    return vn, ve, vd
