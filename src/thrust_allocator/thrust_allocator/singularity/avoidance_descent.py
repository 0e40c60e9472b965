"""Downhill in the angles, without going below a required minimum gain: question (a) of [Ruth] 8.2."""

from __future__ import annotations

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, cost_slope, gain_at, gain_slope, static_cost

_ATTEMPTS = 8  # step lengths tried, each a quarter of the one before
_RESTORATIONS = 3  # steps back over the limit after one along its tangent
_BISECTIONS = 40
_FIRST_TURN = 0.1  # rad, the first step's length; it adapts
_SMALLEST_DECREASE = 1e-10  # share of the cost below which a step is not worth it


@compiled
def _least_move(
    slope: FloatArray, normal: FloatArray, need: float, curvature: float, low: FloatArray, high: FloatArray,
    move: FloatArray,
) -> None:  # fmt: skip
    """Write the minimum of slope' d + curvature |d|^2 / 2 over low <= d <= high, normal' d >= need.

    For a multiplier nu of the last, every element is on its own; nu comes from bisection. Where the box leaves nothing
    that meets ``need``, d is as near to it as the box allows.
    """
    n = len(move)

    lower = 0.0
    met = 0.0
    for j in range(n):
        move[j] = min(max(-slope[j] / curvature, low[j]), high[j])
        met += normal[j] * move[j]
    if met >= need:
        return
    size = 0.0
    for j in range(n):
        size += normal[j] * normal[j]
    if size == 0.0:
        return
    upper = curvature * (need - met) / size
    for _ in range(_BISECTIONS):
        met = 0.0
        for j in range(n):
            met += normal[j] * min(max((upper * normal[j] - slope[j]) / curvature, low[j]), high[j])
        if met >= need:
            break
        lower, upper = upper, 2.0 * upper
    for _ in range(_BISECTIONS):
        nu = 0.5 * (lower + upper)
        met = 0.0
        for j in range(n):
            met += normal[j] * min(max((nu * normal[j] - slope[j]) / curvature, low[j]), high[j])
        if met >= need:
            upper = nu
        else:
            lower = nu
    for j in range(n):
        move[j] = min(max((upper * normal[j] - slope[j]) / curvature, low[j]), high[j])


@compiled
def descend(
    thrusters: Thrusters,
    tau: FloatArray,
    threshold: float,
    low: FloatArray,
    high: FloatArray,
    steps: int,
    azimuth: FloatArray,
) -> float:
    """Turn ``azimuth``, shape (n,), downhill in :func:`static_cost`, in place; return the cost.

    A projected gradient method with step lengths after Barzilai and Borwein. The gain is linearised at every step, and
    Newton steps lead back where it curves; a step counts only if the gain is kept and the cost is less, so that every
    point of the way is allowed if the start is.

    Parameters
    ----------
    thrusters, tau
        As in :func:`static_cost`.
    threshold
        Gain to keep; that of the start if it has less.
    low, high
        How far each may turn from the start, shape (n,), rad, low <= 0 <= high.
    steps
        At most.
    azimuth
        Start; overwritten.
    """
    n = len(azimuth)
    start = azimuth.copy()
    slope, normal, move = np.empty(n), np.empty(n), np.empty(n)
    room_low, room_high = np.empty(n), np.empty(n)
    trial, before, thrust = np.empty(n), np.empty(n), np.empty(n)
    there, unused = np.empty(n), np.empty(3)
    multiplier = np.zeros(3)
    cost = static_cost(thrusters, azimuth, tau, multiplier, thrust)
    cost_slope(thrusters, azimuth, multiplier, thrust, slope)
    keep = min(threshold, gain_at(thrusters, azimuth, unused))
    steepest = np.abs(slope).max()
    if steepest == 0.0:
        return cost
    curvature = steepest / _FIRST_TURN
    for _ in range(steps):
        gain = gain_slope(thrusters, azimuth, normal)
        for j in range(n):
            room_low[j], room_high[j] = start[j] + low[j] - azimuth[j], start[j] + high[j] - azimuth[j]
        before[:] = slope
        accepted = False
        for _attempt in range(_ATTEMPTS):
            _least_move(slope, normal, keep - gain, curvature, room_low, room_high, move)
            for j in range(n):
                trial[j] = azimuth[j] + move[j]
            reached = gain_slope(thrusters, trial, there)
            for _restoration in range(_RESTORATIONS):
                if reached >= keep:
                    break
                size = 0.0
                for j in range(n):
                    size += there[j] * there[j]
                if size == 0.0:
                    break
                # A little more than the tangent says, or the curve would be approached from below for ever.
                share = (keep * (1.0 + 1e-6) - reached) / size
                for j in range(n):
                    move[j] = min(max(move[j] + share * there[j], room_low[j]), room_high[j])
                    trial[j] = azimuth[j] + move[j]
                reached = gain_slope(thrusters, trial, there)
            if reached >= keep:
                multiplier[:] = 0.0
                cost_there = static_cost(thrusters, trial, tau, multiplier, thrust)
                if cost_there < cost * (1.0 - _SMALLEST_DECREASE):
                    accepted = True
                    break
            curvature *= 4.0
        if not accepted:
            break
        azimuth[:] = trial
        cost = cost_there
        cost_slope(thrusters, azimuth, multiplier, thrust, slope)
        bend, size = 0.0, 0.0
        for j in range(n):
            bend += (slope[j] - before[j]) * move[j]
            size += move[j] * move[j]
        # Where the cost bends down there is no such length; the next step is twice as long.
        curvature = bend / size if bend > 1e-6 * curvature * size else 0.5 * curvature
    return cost
