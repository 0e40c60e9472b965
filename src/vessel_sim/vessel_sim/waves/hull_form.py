"""The hull as a box, and its first-order motion in waves."""

from __future__ import annotations

import math
from dataclasses import dataclass

from marine_model.compiled import compiled
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.waves.components import AMPLITUDE, COS_BETA, GROWTH, OMEGA, SIN_BETA, WAVE_NUMBER, phase

Triple = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class HullForm:
    """A box of the length, beam and draught of the hull, and what waves do to it.

    First-order motion: the box is carried with the water that it displaces (Froude-Krylov forces; diffraction, and
    the resonance of heave, roll and pitch, left out). Surge, sway and heave are the mean of the particle displacement
    over the box. Yaw is the rotation that fits the horizontal displacements best, integral(x xi_y - y xi_x) /
    integral(x^2 + y^2); roll and pitch are the slopes that fit the vertical ones best. With b the direction
    of the waves relative to the heading, X = k L cos b / 2, Y = k B sin b / 2 and e = (1 - exp(-k T)) / (k T),
    in the body axes (heave down, pitch bow up, roll starboard down):

        surge = -a e j0(X) j0(Y) cos b sin(theta)
        sway  = -a e j0(X) j0(Y) sin b sin(theta)
        heave = -a e j0(X) j0(Y) cos(theta)
        roll  =  a e 6 / B j0(X) j1(Y) sin(theta)
        pitch = -a e 6 / L j1(X) j0(Y) sin(theta)
        yaw   = -a e 6 [L j1(X) j0(Y) sin b - B j0(X) j1(Y) cos b] / (L^2 + B^2) cos(theta)

    In long waves the hull heaves with the surface and lies along its slope; in short ones it does not move.

    Mean drift: see ``marine_model.hull.WaveForces``.
    """

    length: float
    beam: float
    draught: float
    drift: Triple  # N/m^2, N/m^2, N/m: force per amplitude squared at the heading where each is largest

    @classmethod
    def of(cls, vessel: Vessel) -> HullForm:
        """Return the box of ``vessel``. Raises InputError if its waves are given by a data file."""
        hull = vessel.hull
        if vessel.wave_forces.drift_coefficient is None:
            raise InputError("wave_forces: expected drift_coefficient, found a data file")
        c0, c1, c2 = vessel.wave_forces.drift_coefficient
        half = 0.5 * vessel.density * GRAVITY
        return cls(
            hull.length,
            hull.beam,
            hull.draught,
            (
                c0 * half * hull.beam,
                c1 * half * hull.length,
                c2 * half * hull.length * hull.beam,
            ),
        )

    @property
    def box(self) -> Triple:
        """Length, beam, draught, m."""
        return self.length, self.beam, self.draught


@compiled
def _j0(x: float) -> float:
    """Spherical Bessel function of order 0: the mean of cos(2 x s) over -1/2 < s < 1/2."""
    return math.sin(x) / x if abs(x) > 1e-4 else 1.0 - x * x / 6.0


@compiled
def _j1(x: float) -> float:
    """Spherical Bessel function of order 1; below 0.01 by its series, where the two terms cancel."""
    if abs(x) < 0.01:
        return x / 3.0 * (1.0 - x * x / 10.0)
    return (math.sin(x) / x - math.cos(x)) / x


@compiled
def box_response(box: Triple, wave_number: float, cos_b: float, sin_b: float) -> Six:
    """Return amplitudes per metre of wave, with the signs of ``HullForm``.

    Surge, sway, roll (rad/m) and pitch (rad/m) go with sin(theta), heave and yaw (rad/m) with cos(theta).
    """
    length, beam, draught = box
    kt = wave_number * draught
    depth = -math.expm1(-kt) / kt
    x = 0.5 * wave_number * length * cos_b
    y = 0.5 * wave_number * beam * sin_b
    j0x, j0y = _j0(x), _j0(y)
    j1x, j1y = _j1(x), _j1(y)
    mean = depth * j0x * j0y
    lever = length * j1x * j0y * sin_b - beam * j0x * j1y * cos_b
    return (
        -mean * cos_b,
        -mean * sin_b,
        -mean,
        depth * 6.0 / beam * j0x * j1y,
        -depth * 6.0 / length * j1x * j0y,
        -depth * 6.0 * lever / (length * length + beam * beam),
    )


@compiled
def box_motion(
    components: FloatArray, box: Triple, position: Triple, velocity: tuple[float, float], time: float
) -> tuple[Six, Six]:
    """Return the first-order displacement of the box and its rate of change, in the body axes.

    Surge, sway, heave (m), roll, pitch, yaw (rad).

    Parameters
    ----------
    components
        The sea.
    box
        Length, beam, draught, m.
    position
        Low-frequency position: north (m), east (m), heading (rad).
    velocity
        Low-frequency velocity over ground: north, east (m/s). It shifts the frequency to that of encounter.
        The slow turn of the hull relative to the waves is left out of the rate of change.
    time
        s.
    """
    north, east, heading = position
    c, s = math.cos(heading), math.sin(heading)
    p0 = p1 = p2 = p3 = p4 = p5 = 0.0
    v0 = v1 = v2 = v3 = v4 = v5 = 0.0
    for i in range(components.shape[0]):
        row = components[i]
        cos_beta, sin_beta, k = row[COS_BETA], row[SIN_BETA], row[WAVE_NUMBER]
        r0, r1, r2, r3, r4, r5 = box_response(box, k, cos_beta * c + sin_beta * s, sin_beta * c - cos_beta * s)
        theta = phase(row, north, east, time)
        theta_dot = k * (velocity[0] * cos_beta + velocity[1] * sin_beta) - row[OMEGA]
        sin_t, cos_t = math.sin(theta), math.cos(theta)
        a, a_dot = row[AMPLITUDE], row[GROWTH]
        with_sin, with_cos = a * sin_t, a * cos_t
        sin_rate = a_dot * sin_t + with_cos * theta_dot
        cos_rate = a_dot * cos_t - with_sin * theta_dot
        p0 += r0 * with_sin
        p1 += r1 * with_sin
        p2 += r2 * with_cos
        p3 += r3 * with_sin
        p4 += r4 * with_sin
        p5 += r5 * with_cos
        v0 += r0 * sin_rate
        v1 += r1 * sin_rate
        v2 += r2 * cos_rate
        v3 += r3 * sin_rate
        v4 += r4 * sin_rate
        v5 += r5 * cos_rate
    return (p0, p1, p2, p3, p4, p5), (v0, v1, v2, v3, v4, v5)
