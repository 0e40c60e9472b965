"""Gain and least cost of thrusters at given angles, as singularity avoidance needs them hundreds of times a step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.plan.polygon import CORNERS
from thrust_allocator.program.active_set import IntArray, solve
from thrust_allocator.singularity.theorem import svd_gain

_SMALLEST_GAIN = 1e-9  # below it the gradient of a gain is not divided by it


class Thrusters(NamedTuple):
    """What does not depend on angles. Reverse thrust counts, as in the third step of [Ruth] 7.8.1.

    Attributes
    ----------
    columns
        Generalized force of a newton along either body axis, shape (n, 3, 2).
    scaled
        The same of the largest thrust, scaled by [Ruth] (7.4), shape (n, 3, 2).
    weight
        Diagonal of W_u^2, shape (n,).
    compliance
        Inverse of the diagonal of (gamma W_v)^2, shape (3,).
    low, high
        Limits of thrust, shape (n,), N.
    used
        Indices of the thrusters that are not lost.
    turning
        Indices of those that can turn.
    """

    columns: FloatArray
    scaled: FloatArray
    weight: FloatArray
    compliance: FloatArray
    low: FloatArray
    high: FloatArray
    used: IntArray
    turning: IntArray


@compiled
def gain_at(thrusters: Thrusters, azimuth: FloatArray, direction: FloatArray) -> float:
    """Return the smallest singular value of B_S at ``azimuth``, shape (n,), rad; write its direction, shape (3,)."""
    scaled, used = thrusters.scaled, thrusters.used
    B = np.empty((3, len(used)))
    for i in range(len(used)):
        j = used[i]
        c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
        for a in range(3):
            B[a, i] = scaled[j, a, 0] * c + scaled[j, a, 1] * s
    return svd_gain(B, direction)[0]


@compiled
def gain_slope(thrusters: Thrusters, azimuth: FloatArray, slope: FloatArray) -> float:
    """Return the gain; write its derivative by every azimuth, shape (n,), 1/rad, zero for those that cannot turn.

    d sigma = u' dB v with v = B' u / sigma: (u' b_j)(u' b_j') / sigma for thruster j. Where two singular values meet
    it is the slope of one of them.
    """
    u = np.empty(3)
    gain = gain_at(thrusters, azimuth, u)
    slope[:] = 0.0
    for j in thrusters.turning:
        c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
        along, across = 0.0, 0.0
        for a in range(3):
            along += u[a] * (thrusters.scaled[j, a, 0] * c + thrusters.scaled[j, a, 1] * s)
            across += u[a] * (thrusters.scaled[j, a, 1] * c - thrusters.scaled[j, a, 0] * s)
        slope[j] = along * across / max(gain, _SMALLEST_GAIN)
    return gain


@compiled
def static_cost(
    thrusters: Thrusters, azimuth: FloatArray, tau: FloatArray, multiplier: FloatArray, thrust: FloatArray
) -> float:
    """Return the least cost (4.10) with all thrusters along ``azimuth``, without rates.

    Parameters
    ----------
    thrusters, azimuth
        As above.
    tau
        Demand, shape (3,), N, N, N m.
    multiplier
        lambda, shape (3,): start, overwritten with that of the answer.
    thrust
        Receives the thrusts, shape (n,), N.
    """
    n = len(azimuth)
    corners, force = np.zeros((n, CORNERS, 2)), np.zeros((n, 2))
    count, face = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for j in thrusters.used:
        c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
        corners[j, 0, 0], corners[j, 0, 1] = thrusters.low[j] * c, thrusters.low[j] * s
        corners[j, 1, 0], corners[j, 1, 1] = thrusters.high[j] * c, thrusters.high[j] * s
        count[j] = 2
    work = np.empty((3, 4))
    solve(thrusters.columns, thrusters.weight, corners, count, thrusters.compliance, tau, multiplier, force, face, work)
    cost = 0.0
    slack = tau.copy()
    thrust[:] = 0.0
    for j in thrusters.used:
        thrust[j] = force[j, 0] * math.cos(azimuth[j]) + force[j, 1] * math.sin(azimuth[j])
        cost += thrusters.weight[j] * thrust[j] * thrust[j]
        for a in range(3):
            slack[a] -= thrusters.columns[j, a, 0] * force[j, 0] + thrusters.columns[j, a, 1] * force[j, 1]
    for a in range(3):
        cost += slack[a] * slack[a] / thrusters.compliance[a]
        multiplier[a] = slack[a] / thrusters.compliance[a]
    return cost


@compiled
def cost_slope(
    thrusters: Thrusters, azimuth: FloatArray, multiplier: FloatArray, thrust: FloatArray, slope: FloatArray
) -> None:
    """Write the derivative of :func:`static_cost` by every azimuth, shape (n,): -2 lambda' b_j' T_j.

    The thrusts are optimal, so that their own change does not count (envelope theorem).
    """
    slope[:] = 0.0
    for j in thrusters.turning:
        c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
        for a in range(3):
            across = thrusters.columns[j, a, 1] * c - thrusters.columns[j, a, 0] * s
            slope[j] -= 2.0 * multiplier[a] * across * thrust[j]
