"""Mean and slowly varying drift of the hull, compiled."""

from __future__ import annotations

import math

from marine_model.compiled import compiled, inlined
from marine_model.guards import FloatArray
from vessel_sim.waves.components import (
    BETA,
    COS_BETA,
    OMEGA,
    PHASE,
    SIN_BETA,
    WAVE_NUMBER,
    local_amplitude,
)
from vessel_sim.waves.hull_motion import Triple
from vessel_sim.waves.response_table import DRIFT_N, DRIFT_X, DRIFT_Y, between, value


@inlined
def _share(drift: float) -> tuple[float, float]:
    """Return sqrt(D) where the drift is positive, sqrt(-D) where it is negative, and 0 for the other."""
    root = math.sqrt(abs(drift))
    return (root, 0.0) if drift > 0.0 else (0.0, root)


@compiled
def drift_force(components: FloatArray, response: FloatArray, position: Triple, time: float) -> Triple:
    """Return the second-order force of the differences of frequencies: N, N, N m in the body frame.

    Newman's approximation: the force of a pair of components is that of their own mean drifts D, of which the geometric
    mean is taken here, 2 a_i a_j sqrt(D_i D_j) cos(theta_i - theta_j), where both have the same sign. With

        S+ = sum a_i sqrt(D_i) exp(i theta_i) over D_i > 0,    S- = sum a_i sqrt(-D_i) exp(i theta_i) over D_i < 0,

    all pairs together are F = |S+|^2 - |S-|^2, an effort that grows with the number of components and not with its
    square. It has no sums of frequencies. One component gives a^2 D; the mean over time is sum a_i^2 D_i, but for
    components of equal frequency.

    Parameters
    ----------
    components, response, position, time
        See ``hull_motion``.
    """
    north, east, heading = position
    xpc = xps = xmc = xms = ypc = yps = ymc = yms = npc = nps = nmc = nms = 0.0
    for i in range(components.shape[0]):
        along = north * components[i, COS_BETA] + east * components[i, SIN_BETA]
        a, _ = local_amplitude(components, i, along, time)
        if a == 0.0:
            continue
        theta = components[i, WAVE_NUMBER] * along - components[i, OMEGA] * time + components[i, PHASE]
        sin_t, cos_t = a * math.sin(theta), a * math.cos(theta)
        node, w0, w1, s0, s1, sign = between(components[i, BETA] - heading)
        plus, minus = _share(value(response, i, node, DRIFT_X, w0, w1, s0, s1))
        xpc += plus * cos_t
        xps += plus * sin_t
        xmc += minus * cos_t
        xms += minus * sin_t
        plus, minus = _share(sign * value(response, i, node, DRIFT_Y, w0, w1, s0, s1))
        ypc += plus * cos_t
        yps += plus * sin_t
        ymc += minus * cos_t
        yms += minus * sin_t
        plus, minus = _share(sign * value(response, i, node, DRIFT_N, w0, w1, s0, s1))
        npc += plus * cos_t
        nps += plus * sin_t
        nmc += minus * cos_t
        nms += minus * sin_t
    return (
        xpc * xpc + xps * xps - xmc * xmc - xms * xms,
        ypc * ypc + yps * yps - ymc * ymc - yms * yms,
        npc * npc + nps * nps - nmc * nmc - nms * nms,
    )
