"""Thrust and torque of one propeller as machine code, from the packed parameters of any model (``PropellerModel.row``).

Two kinds of row are enough for all models. ``PIECEWISE``: K_T and K_Q are polynomials in advance number and pitch
ratio, piece by piece; bollard, linear and polynomial propellers, the Wageningen B-series and tables are that exactly.
``FOURIER``: C_T and C_Q are Fourier series of the advance angle. In both, the pitch ratio is held to the range of the
model.
``LINEAR`` is a ``PIECEWISE`` row of one piece that is linear in the advance number at one pitch: it is its own tangent.

A first-quadrant model (``PIECEWISE``) goes on outside its range: below J = 0 along its tangent at 0, beyond the end
along the tangent there, and for n < 0 by odd symmetry, T(n, V_A) = -T(-n, -V_A). With intercept k0 and slope k1 of the
tangent at the held J that is

    T = rho D^4 (k0 n |n| + k1 |n| V_A / D),

which is finite at n = 0, and exact for a model linear in J at every n and V_A.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled, inlined
from marine_model.guards import FloatArray
from marine_model.propellers.rows import (
    ADVANCE_PIECES,
    ADVANCE_TERMS,
    BREAKS,
    CERTAINLY_INSIDE,
    END,
    END_IS_ZERO_THRUST,
    END_STEPS,
    FOURIER,
    HARMONICS,
    KIND,
    LINEAR,
    LINEAR_COEFFICIENTS,
    PITCH_MAX,
    PITCH_MIN,
    PITCH_PIECES,
    PITCH_TERMS,
    ROTATION,
    SPLINE_TERMS,
)


@inlined
def thrust_torque(
    row: FloatArray, diameter: float, density: float, shaft_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float]:
    """Return thrust (N) and propeller torque (N m).

    Parameters
    ----------
    row
        ``PropellerModel.row()``; zeros behind it do no harm.
    diameter, density
        D, m, and rho, kg/m^3.
    shaft_speed, advance_speed
        n, Hz, and V_A, m/s, of either sign.
    pitch_ratio
        P/D, held to the range of the model.
    """
    if row[KIND] == FOURIER:
        c_t, c_q, _, _ = fourier(row, ROTATION * shaft_speed * diameter, advance_speed, pitch_ratio)
        area_pressure = _area_pressure(diameter, density, shaft_speed, advance_speed)
        return area_pressure * c_t, area_pressure * diameter * c_q
    t0, t1, q0, q1 = tangents(row, diameter, shaft_speed, advance_speed, pitch_ratio)
    square = shaft_speed * abs(shaft_speed)
    cross = abs(shaft_speed) * advance_speed / diameter
    scale = density * diameter**4
    return scale * (t0 * square + t1 * cross), scale * diameter * (q0 * square + q1 * cross)


@inlined
def load(
    row: FloatArray, diameter: float, density: float, shaft_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float, float]:
    """Return (c, a, b) so that the propeller torque is c n |n| + a |n| + b near the present n.

    Value and slope agree at the present n, so that the error is of second order in the change of n; c > 0. For a
    first-quadrant model b = 0 (the tangent of K_Q in J, exact for one linear in J). With a four-quadrant model a
    propeller at rest in a flow has a torque: b. Its c is that of zero advance speed. At n = 0 the side n > 0 is taken.

    Parameters are those of ``thrust_torque``. Units: N m s^2, N m s, N m.
    """
    if row[KIND] == FOURIER:
        return _fourier_load(row, diameter, density, shaft_speed, advance_speed, pitch_ratio)
    _, _, q0, q1 = tangents(row, diameter, shaft_speed, advance_speed, pitch_ratio)
    scale = density * diameter**4
    return scale * diameter * q0, scale * q1 * advance_speed, 0.0


@inlined
def tangents(
    row: FloatArray, diameter: float, shaft_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float, float, float]:
    """Return intercept and slope of the tangents of K_T and of K_Q at the advance number held to its range."""
    if row[KIND] == LINEAR:
        at = LINEAR_COEFFICIENTS
        return row[at], row[at + 1], row[at + ADVANCE_TERMS], row[at + ADVANCE_TERMS + 1]
    advance_number = _advance_number(diameter, shaft_speed, advance_speed)
    pitch = min(max(pitch_ratio, row[PITCH_MIN]), row[PITCH_MAX])
    pitch_pieces, terms, pieces = int(row[PITCH_PIECES]), int(row[PITCH_TERMS]), int(row[ADVANCE_PIECES])
    breaks = BREAKS + pitch_pieces + 1
    k = _piece(row, BREAKS, pitch_pieces, pitch)
    x = pitch - row[BREAKS + k]
    end = row[END] + pitch * (row[END + 1] + pitch * (row[END + 2] + pitch * row[END + 3]))
    # A range that ends at zero thrust is one piece, so that its cubic is known before its end is.
    advance = min(max(advance_number, 0.0), end)
    i = _piece(row, breaks, pieces, advance)
    first = breaks + pieces + 1 + (k * pieces + i) * 2 * ADVANCE_TERMS * terms
    t0, t1, t2, t3, q0, q1, q2, q3 = _cubics(row, first, terms, x)
    if row[END_IS_ZERO_THRUST] != 0.0 and advance_number > CERTAINLY_INSIDE * end:
        for _ in range(END_STEPS):
            end -= (t0 + end * (t1 + end * (t2 + end * t3))) / (t1 + end * (2.0 * t2 + end * 3.0 * t3))
        advance = min(max(advance_number, 0.0), end)
    y = advance - row[breaks + i]
    t = t0 + y * (t1 + y * (t2 + y * t3))
    t1 = t1 + y * (2.0 * t2 + y * 3.0 * t3)
    q = q0 + y * (q1 + y * (q2 + y * q3))
    q1 = q1 + y * (2.0 * q2 + y * 3.0 * q3)
    return t - t1 * advance, t1, q - q1 * advance, q1


@inlined
def fourier(
    row: FloatArray, rotation_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float, float, float]:
    """Return C_T, C_Q, the slope of C_Q over the advance angle, and C_Q without advance speed.

    The advance angle is that of the vector (``rotation_speed``, ``advance_speed``), m/s; 0 at rest. The last value is
    at 0 for angles within 90 deg of it, otherwise at 180 deg.
    """
    pitch = min(max(pitch_ratio, row[PITCH_MIN]), row[PITCH_MAX])
    pitch_pieces, terms, harmonics = int(row[PITCH_PIECES]), int(row[PITCH_TERMS]), int(row[HARMONICS])
    k = _piece(row, BREAKS, pitch_pieces, pitch)
    x = pitch - row[BREAKS + k]
    size = 4 * terms
    at = BREAKS + pitch_pieces + 1 + k * harmonics * size
    c, s = _direction(rotation_speed, advance_speed)
    # Even and odd harmonics turn on their own, by twice the angle: two short chains of products, not one long one.
    c2, s2 = c * c - s * s, 2.0 * s * c
    cosine, sine, cosine_odd, sine_odd = 1.0, 0.0, c, s
    c_t, c_q, slope, even, odd = 0.0, 0.0, 0.0, 0.0, 0.0
    for h in range(0, harmonics, 2):
        a_t, b_t, a_q, b_q = _harmonic(row, at, terms, x)
        c_t += a_t * cosine + b_t * sine
        c_q += a_q * cosine + b_q * sine
        slope += h * (b_q * cosine - a_q * sine)
        even += a_q
        cosine, sine = cosine * c2 - sine * s2, sine * c2 + cosine * s2
        if h + 1 < harmonics:
            a_t, b_t, a_q, b_q = _harmonic(row, at + size, terms, x)
            c_t += a_t * cosine_odd + b_t * sine_odd
            c_q += a_q * cosine_odd + b_q * sine_odd
            slope += (h + 1) * (b_q * cosine_odd - a_q * sine_odd)
            odd += a_q
            cosine_odd, sine_odd = cosine_odd * c2 - sine_odd * s2, sine_odd * c2 + cosine_odd * s2
        at += 2 * size
    return c_t, c_q, slope, (even + odd if c >= 0.0 else even - odd)


@compiled
def _fourier_load(
    row: FloatArray, diameter: float, density: float, shaft_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float, float]:
    rotation = ROTATION * diameter
    x = rotation * shaft_speed
    _, c_q, slope, still = fourier(row, x, advance_speed, pitch_ratio)
    torque = _area_pressure(diameter, density, shaft_speed, advance_speed) * diameter * c_q
    scale = 0.125 * math.pi * density * diameter**3
    per_speed = scale * rotation * (2.0 * x * c_q - advance_speed * slope)
    c = abs(scale * rotation**2 * still)
    a = per_speed - 2.0 * c * abs(shaft_speed)
    b = torque - c * shaft_speed * abs(shaft_speed) - a * shaft_speed
    return c, (a if shaft_speed >= 0.0 else -a), b


@inlined
def _area_pressure(diameter: float, density: float, shaft_speed: float, advance_speed: float) -> float:
    """Return rho A_0 V_inf^2 / 2, N: [Ruth] (2.13), (2.15), (2.16)."""
    rotation = ROTATION * shaft_speed * diameter
    return 0.125 * math.pi * density * diameter**2 * (advance_speed * advance_speed + rotation * rotation)


@inlined
def _advance_number(diameter: float, shaft_speed: float, advance_speed: float) -> float:
    """Return J of [Ruth] (2.11); at n = 0 infinity with the sign of V_A, and 0 where both are 0."""
    if advance_speed == 0.0:
        return 0.0
    if shaft_speed != 0.0:
        return advance_speed / (shaft_speed * diameter)
    return math.copysign(math.inf, advance_speed)


@inlined
def _piece(row: FloatArray, breaks: int, pieces: int, at: float) -> int:
    """Return which piece holds ``at``: the first or last one where it lies outside."""
    i = 0
    while i < pieces - 1 and at >= row[breaks + i + 1]:
        i += 1
    return i


@inlined
def _direction(x: float, y: float) -> tuple[float, float]:
    """Return cosine and sine of the angle of a vector; those of 0 for one of no length."""
    size = max(abs(x), abs(y))
    if size == 0.0:
        return 1.0, 0.0
    length = math.sqrt(x * x + y * y)
    if not 1e-150 < length < 1e150:  # squares that have lost digits, or too large
        x, y = x / size, y / size
        length = math.sqrt(x * x + y * y)
    return x / length, y / length


@inlined
def _cubics(
    row: FloatArray, first: int, terms: int, x: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the coefficients in J of K_T, then of K_Q, at one pitch ratio, lowest power first."""
    at = first + 8 * (terms - 1)
    t0, t1, t2, t3 = row[at], row[at + 1], row[at + 2], row[at + 3]
    q0, q1, q2, q3 = row[at + 4], row[at + 5], row[at + 6], row[at + 7]
    while at > first:
        at -= 8
        t0, t1, t2, t3 = t0 * x + row[at], t1 * x + row[at + 1], t2 * x + row[at + 2], t3 * x + row[at + 3]
        q0, q1, q2, q3 = q0 * x + row[at + 4], q1 * x + row[at + 5], q2 * x + row[at + 6], q3 * x + row[at + 7]
    return t0, t1, t2, t3, q0, q1, q2, q3


@inlined
def _harmonic(row: FloatArray, first: int, terms: int, x: float) -> tuple[float, float, float, float]:
    """Return A_T, B_T, A_Q and B_Q of one harmonic at one pitch ratio."""
    if terms == SPLINE_TERMS:  # the same as below, without a loop
        c = row[first : first + 4 * SPLINE_TERMS]
        return (
            c[0] + x * (c[4] + x * (c[8] + x * c[12])),
            c[1] + x * (c[5] + x * (c[9] + x * c[13])),
            c[2] + x * (c[6] + x * (c[10] + x * c[14])),
            c[3] + x * (c[7] + x * (c[11] + x * c[15])),
        )
    at = first + 4 * (terms - 1)
    a_t, b_t, a_q, b_q = row[at], row[at + 1], row[at + 2], row[at + 3]
    while at > first:
        at -= 4
        a_t, b_t, a_q, b_q = a_t * x + row[at], b_t * x + row[at + 1], a_q * x + row[at + 2], b_q * x + row[at + 3]
    return a_t, b_t, a_q, b_q
