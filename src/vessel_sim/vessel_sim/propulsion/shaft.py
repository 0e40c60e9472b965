"""One propeller shaft under constant motor torque, solved in closed form.

    2 pi J dn/dt = Q_m - (c n |n| + a |n|) - Q_v n - Q_s sgn(n)

n in Hz. c and a are the propeller's load near the present shaft speed and advance speed, times the torque loss factor;
for a torque coefficient linear in the advance number, [Ruth] (3.6)-(3.7), c = beta_Q K_Q0 rho D^5 and
a = beta_Q a_Q rho D^4 V_A. a |n| helps to turn the shaft where a n < 0: a propeller may windmill.

On either side of n = 0 this is a Riccati equation. With u = |n|, its own direction positive,

    du/dt = p - 2 b u - k u^2,   b^2 + k p = s^2,

    u(t) = (u_0 (1 - b S) + p S) / (1 + (b + k u_0) S),   S = tanh(s t) / s,

where S is tan(w t) / w for s^2 = -w^2 < 0 and t for s = 0. It holds for k = 0, a propeller in air, as well. u is 0 when
S = u_0 / (b u_0 - p). The step is exact for any length: no time constant of a shaft bounds the time step. Coulomb
friction holds the shaft at rest while |Q_m| <= Q_s.

S / t is a function of z = s^2 t^2 alone, the same on both sides of 0. A step is short beside the time constant of a
shaft as a rule, and z small; then S / t is a ratio of two polynomials in z, and a step takes neither roots nor
exponentials.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled, inlined

_TWO_PI = 2.0 * math.pi
# Below this |z|, S / t = 1 / (1 + z / (3 + z / (5 + ...))) is cut off after 13, and written as a ratio of polynomials.
# What is left out is below 3e-16 of it.
_SHORT = 0.25
_OVER = (135135.0, 17325.0, 378.0, 1.0)
_UNDER = (135135.0, 62370.0, 3150.0, 28.0)


@inlined
def advance(
    speed: float, torque: float, inertia: float, c: float, a: float, viscous: float, static: float, dt: float
) -> float:
    """Return the shaft speed (Hz) after ``dt``.

    Parameters
    ----------
    speed
        Shaft speed at the start, Hz.
    torque
        Motor torque Q_m, held over the step, N m.
    inertia
        J, kg m^2, above 0.
    c
        Load per shaft speed squared, N m s^2, at least 0.
    a
        Load per shaft speed from the advance speed, N m s, of either sign.
    viscous
        Q_v, N m s: friction per Hz, at least 0.
    static
        Q_s, N m: Coulomb friction, at least 0.
    dt
        s, at least 0.
    """
    if speed == 0.0 and abs(torque) <= static:
        return 0.0
    side = math.copysign(1.0, speed if speed != 0.0 else torque)
    ahead = side * torque
    u, left = _one_way(side * speed, ahead - static, inertia, c, viscous + side * a, dt)
    if left > 0.0 and ahead < -static:
        return -side * _from_rest(-ahead - static, inertia, c, viscous - side * a, left)
    return side * u


@inlined
def _one_way(u: float, torque: float, inertia: float, c: float, linear: float, dt: float) -> tuple[float, float]:
    """Return u after ``dt`` and 0, or 0 and the time left after coming to rest. ``u`` >= 0."""
    per_inertia = 1.0 / (_TWO_PI * inertia)
    p = torque * per_inertia
    b = 0.5 * linear * per_inertia
    k = c * per_inertia
    square = b * b + k * p
    z = square * (dt * dt)
    if abs(z) < _SHORT:
        under = _UNDER[0] + z * (_UNDER[1] + z * (_UNDER[2] + z * _UNDER[3]))
        reach = dt * (_OVER[0] + z * (_OVER[1] + z * (_OVER[2] + z * _OVER[3])))  # S times ``under``
        above = u * under - (b * u - p) * reach
        if above >= 0.0 or p >= 0.0:
            return max(above, 0.0) / (under + (b + k * u) * reach), 0.0
    return _any_length(u, p, b, k, square, dt)


@compiled
def _from_rest(torque: float, inertia: float, c: float, linear: float, dt: float) -> float:
    return _one_way(0.0, torque, inertia, c, linear, dt)[0]


@compiled
def _any_length(u: float, p: float, b: float, k: float, square: float, dt: float) -> tuple[float, float]:
    """Return u after ``dt`` and 0, or 0 and the time left after coming to rest; ``square`` is s^2."""
    if square < 0.0:  # no balance: the shaft slows down to rest
        w = math.sqrt(-square)
        at_rest = math.atan2(w * u, b * u - p) / w
        if at_rest <= dt:
            return 0.0, dt - at_rest
        x = w * dt
        long = math.sin(x) / w
        short = math.cos(x)
        return max((u * (short - b * long) + p * long) / (short + (b + k * u) * long), 0.0), 0.0
    s = math.sqrt(square)
    if p < 0.0:
        # Rest is ahead unless a windmilling propeller turns faster than its unstable balance -p / (s - b).
        slack = b * u - p
        if s * u < slack:
            x = u / slack
            at_rest = math.atanh(s * x) / s if s * x > 0.0 else x
            if at_rest <= dt:
                return 0.0, dt - at_rest
    if square * (dt * dt) < _SHORT:  # at rest, and the time of it beyond ``dt`` by rounding
        return 0.0, 0.0
    x = s * dt
    # Times s (1 + exp(-2 x)). s - b and s + b are both wanted to all their digits.
    if b > 0.0:
        above = s + b
        below = k * p / above
    else:
        below = s - b
        above = k * p / below
    decay = math.exp(-2.0 * x)  # at most 0.37: 1 - decay keeps its digits
    rise = 1.0 - decay
    return max((u * (below + above * decay) + p * rise) / (above + below * decay + k * u * rise), 0.0), 0.0
