"""Gusts as a sum of harmonic components, drawn at full scale and brought to the scale of the vessel."""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray
from vessel_sim.noise import generator
from vessel_sim.wind import npd

# Columns of a table of components.
FREQUENCY, AMPLITUDE, PHASE = range(3)


def components(count: int, mean: float, height: float, scale: float, seed: int) -> FloatArray:
    """Return angular frequency (rad/s), amplitude (m/s) and phase (rad) of every component, shape (count, 3).

    The band of the spectrum is divided into parts of equal ratio; each component has the variance of its part, and a
    frequency drawn in it, so that the gusts do not repeat. By Froude's law the times of the ship, drawn at full scale,
    are divided by the square root of the scale, and so are its speeds. Of one seed, frequencies and phases do not
    depend on the wind.

    Parameters
    ----------
    count
        Number of components.
    mean
        Mean wind speed at the reference height, m/s, at the scale of the vessel; above 0.
    height
        Where the gusts are felt, m above the water, at the scale of the vessel.
    scale
        Length of the ship over length of the vessel.
    seed
        Of the run.
    """
    draw = generator(seed, "gusts").random((count, 2))
    edges = np.geomspace(npd.LOWEST, npd.HIGHEST, count + 1)
    root = math.sqrt(scale)
    variance = np.diff(npd.variance_below(edges, mean * root, height * scale))
    table = np.empty((count, 3))
    table[:, FREQUENCY] = 2.0 * math.pi * edges[:-1] * (edges[1:] / edges[:-1]) ** draw[:, 0] * root
    table[:, AMPLITUDE] = np.sqrt(2.0 * variance) / root
    table[:, PHASE] = 2.0 * math.pi * draw[:, 1]
    return table
