"""First-order motion of the hull, compiled."""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from vessel_sim.waves.components import (
    BETA,
    COS_BETA,
    OMEGA,
    PHASE,
    SIN_BETA,
    SLOWNESS,
    WAVE_NUMBER,
    local_amplitude,
)
from vessel_sim.waves.response_table import between, value

Triple = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]


@compiled
def hull_motion(
    components: FloatArray, response: FloatArray, position: Triple, velocity: tuple[float, float], time: float
) -> tuple[Six, Six]:
    """Return the first-order displacement of the hull and its rate of change, in the body axes.

    Surge, sway, heave (m), roll, pitch, yaw (rad).

    Parameters
    ----------
    components
        The sea.
    response
        Of the hull to them, see ``response_table``.
    position
        Low-frequency position: north (m), east (m), heading (rad).
    velocity
        Low-frequency velocity over ground: north, east (m/s). It shifts the frequency to that of encounter.
        The slow turn of the hull relative to the waves is left out of the rate of change.
    time
        s.
    """
    north, east, heading = position
    p0 = p1 = p2 = p3 = p4 = p5 = 0.0
    v0 = v1 = v2 = v3 = v4 = v5 = 0.0
    for i in range(components.shape[0]):
        along = north * components[i, COS_BETA] + east * components[i, SIN_BETA]
        a, growth = local_amplitude(components, i, along, time)
        if a == 0.0 and growth == 0.0:
            continue
        k = components[i, WAVE_NUMBER]
        speed = velocity[0] * components[i, COS_BETA] + velocity[1] * components[i, SIN_BETA]
        theta = k * along - components[i, OMEGA] * time + components[i, PHASE]
        theta_dot = k * speed - components[i, OMEGA]
        a_dot = growth * (1.0 - speed * components[i, SLOWNESS])
        sin_t, cos_t = math.sin(theta), math.cos(theta)
        node, w0, w1, s0, s1, sign = between(components[i, BETA] - heading)
        # x = a (Re X cos(theta) - Im X sin(theta)), and its rate.
        with_re, with_im = a * cos_t, -a * sin_t
        re_rate = a_dot * cos_t + with_im * theta_dot
        im_rate = -a_dot * sin_t - with_re * theta_dot
        re, im = value(response, i, node, 0, w0, w1, s0, s1), value(response, i, node, 1, w0, w1, s0, s1)
        p0 += re * with_re + im * with_im
        v0 += re * re_rate + im * im_rate
        re, im = value(response, i, node, 2, w0, w1, s0, s1), value(response, i, node, 3, w0, w1, s0, s1)
        p1 += sign * (re * with_re + im * with_im)
        v1 += sign * (re * re_rate + im * im_rate)
        re, im = value(response, i, node, 4, w0, w1, s0, s1), value(response, i, node, 5, w0, w1, s0, s1)
        p2 += re * with_re + im * with_im
        v2 += re * re_rate + im * im_rate
        re, im = value(response, i, node, 6, w0, w1, s0, s1), value(response, i, node, 7, w0, w1, s0, s1)
        p3 += sign * (re * with_re + im * with_im)
        v3 += sign * (re * re_rate + im * im_rate)
        re, im = value(response, i, node, 8, w0, w1, s0, s1), value(response, i, node, 9, w0, w1, s0, s1)
        p4 += re * with_re + im * with_im
        v4 += re * re_rate + im * im_rate
        re, im = value(response, i, node, 10, w0, w1, s0, s1), value(response, i, node, 11, w0, w1, s0, s1)
        p5 += sign * (re * with_re + im * with_im)
        v5 += sign * (re * re_rate + im * im_rate)
    return (p0, p1, p2, p3, p4, p5), (v0, v1, v2, v3, v4, v5)
