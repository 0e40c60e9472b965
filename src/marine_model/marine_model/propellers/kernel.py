"""Thrust and torque of one propeller as machine code, from the packed parameters of any model (``PropellerModel.row``).

Two kinds of row are enough for all models. ``PIECEWISE``: K_T and K_Q are polynomials in advance number and pitch
ratio, piece by piece; bollard and linear propellers, the Wageningen B-series and tables are that exactly. ``FOURIER``:
C_T and C_Q are Fourier series of the advance angle. In both, the pitch ratio is held to the range of the model.

A first-quadrant model (``PIECEWISE``) goes on outside its range: below J = 0 along its tangent at 0, beyond the end
along the tangent there, and for n < 0 by odd symmetry, T(n, V_A) = -T(-n, -V_A). With intercept k0 and slope k1 of the
tangent at the held J that is

    T = rho D^4 (k0 n |n| + k1 |n| V_A / D),

which is finite at n = 0, and exact for a model linear in J at every n and V_A.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

PIECEWISE, FOURIER = 0, 1

# Columns of a row.
KIND = 0
PITCH_MIN = 1
PITCH_MAX = 2
PITCH_PIECES = 3
PITCH_TERMS = 4  # coefficients of a polynomial in the pitch ratio, lowest power first
ADVANCE_PIECES = 5  # PIECEWISE
HARMONICS = 5  # FOURIER: with the constant term
END = 6  # PIECEWISE: end of the range of J, four coefficients in the pitch ratio
END_IS_ZERO_THRUST = 10  # PIECEWISE: 1 where the end is K_T = 0 and END a first guess of it
# From here: breaks in pitch ratio (PITCH_PIECES + 1). PIECEWISE: breaks in J (ADVANCE_PIECES + 1), then coefficients
# by pitch piece, advance piece, (K_T, K_Q), power of J, power of P/D. FOURIER: coefficients by pitch piece,
# (A_T, B_T, A_Q, B_Q), harmonic, power of P/D. Powers are of the distance from the lower break of the piece.
BREAKS = 11

ADVANCE_TERMS = 4  # cubic in J
# The guess of the end is good to 2 %: Newton on a cubic that falls there squares that three times, to below rounding.
END_STEPS = 4
CERTAINLY_INSIDE = 0.9

ROTATION = 0.7 * math.pi  # tangential over n D at 0.7 R, [Ruth] (2.16)


@compiled
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
        c_t, c_q, _, _ = fourier(row, math.atan2(advance_speed, ROTATION * shaft_speed * diameter), pitch_ratio)
        area_pressure = _area_pressure(diameter, density, shaft_speed, advance_speed)
        return area_pressure * c_t, area_pressure * diameter * c_q
    advance = _advance_number(diameter, shaft_speed, advance_speed)
    t0, t1, q0, q1 = tangents(row, advance, pitch_ratio)
    square = shaft_speed * abs(shaft_speed)
    cross = abs(shaft_speed) * advance_speed / diameter
    scale = density * diameter**4
    return scale * (t0 * square + t1 * cross), scale * diameter * (q0 * square + q1 * cross)


@compiled
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
    advance = _advance_number(diameter, shaft_speed, advance_speed)
    _, _, q0, q1 = tangents(row, advance, pitch_ratio)
    scale = density * diameter**4
    return scale * diameter * q0, scale * q1 * advance_speed, 0.0


@compiled
def tangents(row: FloatArray, advance_number: float, pitch_ratio: float) -> tuple[float, float, float, float]:
    """Return intercept and slope of the tangents of K_T and of K_Q at ``advance_number`` held to its range."""
    pitch = min(max(pitch_ratio, row[PITCH_MIN]), row[PITCH_MAX])
    pitch_pieces, terms, pieces = int(row[PITCH_PIECES]), int(row[PITCH_TERMS]), int(row[ADVANCE_PIECES])
    breaks = BREAKS + pitch_pieces + 1
    coefficients = breaks + pieces + 1
    k = _piece(row, BREAKS, pitch_pieces, pitch)
    x = pitch - row[BREAKS + k]
    size = 2 * ADVANCE_TERMS * terms
    first = coefficients + k * pieces * size
    end = row[END] + pitch * (row[END + 1] + pitch * (row[END + 2] + pitch * row[END + 3]))
    if row[END_IS_ZERO_THRUST] != 0.0 and advance_number > CERTAINLY_INSIDE * end:
        k0, k1, k2, k3 = _cubic(row, first, terms, x)
        for _ in range(END_STEPS):
            end -= (k0 + end * (k1 + end * (k2 + end * k3))) / (k1 + end * (2.0 * k2 + end * 3.0 * k3))
    advance = min(max(advance_number, 0.0), end)
    i = _piece(row, breaks, pieces, advance)
    y = advance - row[breaks + i]
    first += i * size
    k0, k1, k2, k3 = _cubic(row, first, terms, x)
    t = k0 + y * (k1 + y * (k2 + y * k3))
    t1 = k1 + y * (2.0 * k2 + y * 3.0 * k3)
    k0, k1, k2, k3 = _cubic(row, first + ADVANCE_TERMS * terms, terms, x)
    q = k0 + y * (k1 + y * (k2 + y * k3))
    q1 = k1 + y * (2.0 * k2 + y * 3.0 * k3)
    return t - t1 * advance, t1, q - q1 * advance, q1


@compiled
def fourier(row: FloatArray, angle: float, pitch_ratio: float) -> tuple[float, float, float, float]:
    """Return C_T, C_Q, the slope of C_Q at advance angle ``angle`` (rad), and C_Q without advance speed.

    The last one is at 0 for angles within 90 deg of it, otherwise at 180 deg.
    """
    pitch = min(max(pitch_ratio, row[PITCH_MIN]), row[PITCH_MAX])
    pitch_pieces, terms, harmonics = int(row[PITCH_PIECES]), int(row[PITCH_TERMS]), int(row[HARMONICS])
    k = _piece(row, BREAKS, pitch_pieces, pitch)
    x = pitch - row[BREAKS + k]
    size = harmonics * terms
    first = BREAKS + pitch_pieces + 1 + 4 * k * size
    c, s = math.cos(angle), math.sin(angle)
    alternating = 1.0 if c >= 0.0 else -1.0
    cosine, sine, sign = 1.0, 0.0, 1.0
    c_t, c_q, slope, still = 0.0, 0.0, 0.0, 0.0
    for h in range(harmonics):
        at = first + h * terms
        a_q, b_q = _horner(row, at + 2 * size, terms, x), _horner(row, at + 3 * size, terms, x)
        c_t += _horner(row, at, terms, x) * cosine + _horner(row, at + size, terms, x) * sine
        c_q += a_q * cosine + b_q * sine
        slope += h * (b_q * cosine - a_q * sine)
        still += sign * a_q
        sign *= alternating
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    return c_t, c_q, slope, still


@compiled
def _fourier_load(
    row: FloatArray, diameter: float, density: float, shaft_speed: float, advance_speed: float, pitch_ratio: float
) -> tuple[float, float, float]:
    rotation = ROTATION * diameter
    x = rotation * shaft_speed
    _, c_q, slope, still = fourier(row, math.atan2(advance_speed, x), pitch_ratio)
    torque = _area_pressure(diameter, density, shaft_speed, advance_speed) * diameter * c_q
    scale = 0.125 * math.pi * density * diameter**3
    per_speed = scale * rotation * (2.0 * x * c_q - advance_speed * slope)
    c = abs(scale * rotation**2 * still)
    a = per_speed - 2.0 * c * abs(shaft_speed)
    b = torque - c * shaft_speed * abs(shaft_speed) - a * shaft_speed
    return c, (a if shaft_speed >= 0.0 else -a), b


@compiled
def _area_pressure(diameter: float, density: float, shaft_speed: float, advance_speed: float) -> float:
    """Return rho A_0 V_inf^2 / 2, N: [Ruth] (2.13), (2.15), (2.16)."""
    rotation = ROTATION * shaft_speed * diameter
    return 0.125 * math.pi * density * diameter**2 * (advance_speed * advance_speed + rotation * rotation)


@compiled
def _advance_number(diameter: float, shaft_speed: float, advance_speed: float) -> float:
    """Return J of [Ruth] (2.11); at n = 0 infinity with the sign of V_A, and 0 where both are 0."""
    if shaft_speed != 0.0:
        return advance_speed / (shaft_speed * diameter)
    if advance_speed == 0.0:
        return 0.0
    return math.copysign(math.inf, advance_speed)


@compiled
def _piece(row: FloatArray, breaks: int, pieces: int, at: float) -> int:
    """Return which piece holds ``at``: the first or last one where it lies outside."""
    i = 0
    while i < pieces - 1 and at >= row[breaks + i + 1]:
        i += 1
    return i


@compiled
def _horner(row: FloatArray, first: int, terms: int, x: float) -> float:
    value = 0.0
    at = first + terms
    while at > first:  # a range with a negative step divides integers to find its length
        at -= 1
        value = value * x + row[at]
    return value


@compiled
def _cubic(row: FloatArray, first: int, terms: int, x: float) -> tuple[float, float, float, float]:
    """Return the coefficients in J at one pitch ratio, lowest power first."""
    return (
        _horner(row, first, terms, x),
        _horner(row, first + terms, terms, x),
        _horner(row, first + 2 * terms, terms, x),
        _horner(row, first + 3 * terms, terms, x),
    )
