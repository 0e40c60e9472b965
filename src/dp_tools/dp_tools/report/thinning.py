"""Fewer points for a plot, with every peak kept."""

from __future__ import annotations

import itertools

import numpy as np

from marine_model.guards import FloatArray

POINTS = 2400


def thin(t: FloatArray, values: FloatArray, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """Return at most about ``points`` samples of one signal: the lowest and the highest of every stretch of time.

    Parameters
    ----------
    t, values
        Shape (k,).
    points
        How many samples a plot can show.
    """
    count = len(t)
    if count <= points:
        return t, values
    stretches = points // 2
    edges = np.linspace(0, count, stretches + 1).astype(int)
    keep: list[int] = [0, count - 1]
    for first, last in itertools.pairwise(edges):
        part = values[first:last]
        known = np.flatnonzero(np.isfinite(part))
        if len(known) < len(part):
            keep.append(int(first + np.flatnonzero(~np.isfinite(part))[0]))  # the gap stays a gap
        if len(known):
            keep.append(int(first + known[np.argmin(part[known])]))
            keep.append(int(first + known[np.argmax(part[known])]))
    chosen = np.unique(keep)
    return t[chosen], values[chosen]


def break_turns(degrees: FloatArray) -> FloatArray:
    """Return angles (deg, within a turn) with NaN where they pass from +180 to -180, so that no line is drawn there."""
    broken = degrees.astype(np.float64)
    broken[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan
    return broken
