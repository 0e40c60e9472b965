"""The hull as a box, and what waves do to it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from marine_model.compiled import compiled
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.waves.hull_in_waves import HullInWaves
from vessel_sim.waves.hull_motion import Six, Triple
from vessel_sim.waves.response_table import (
    DRIFT_N,
    DRIFT_X,
    DRIFT_Y,
    FUNCTIONS,
    HEAVE_RE,
    NODE_DIRECTIONS,
    PITCH_IM,
    ROLL_IM,
    SURGE_IM,
    SWAY_IM,
    YAW_RE,
)


@dataclass(frozen=True, slots=True)
class HullForm(HullInWaves):
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
    def of(cls, vessel: Vessel, drift_coefficient: Triple | None = None) -> HullForm:
        """Return the box of ``vessel``.

        Parameters
        ----------
        vessel
            Hull and density of the water.
        drift_coefficient
            Of ``marine_model.hull.WaveForces``; that of the vessel file if None.

        Raises
        ------
        InputError
            If neither is there.
        """
        hull = vessel.hull
        coefficient = drift_coefficient or vessel.on_surface()[1].drift_coefficient
        if coefficient is None:
            raise InputError(f"wave_forces.drift_coefficient: expected it in vessel '{vessel.name}', found none")
        c0, c1, c2 = coefficient
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

    def responses(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what the box and the coefficients of drift say at the nodes of the table."""
        values = _box_table(self.box, omega**2 / GRAVITY, NODE_DIRECTIONS)
        cos_b, sin_b = np.cos(NODE_DIRECTIONS), np.sin(NODE_DIRECTIONS)
        # sin(b) |sin(b)|, as b < 0 changes the sign.
        values[:, :, DRIFT_X] = self.drift[0] * cos_b
        values[:, :, DRIFT_Y] = self.drift[1] * sin_b**2
        values[:, :, DRIFT_N] = self.drift[2] * 2.0 * sin_b * cos_b
        return NODE_DIRECTIONS, values


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
def _box_table(box: Triple, wave_number: FloatArray, direction: FloatArray) -> FloatArray:
    """Return first-order motions, shape (m, nb, FUNCTIONS); drift is left at 0."""
    values = np.zeros((wave_number.size, direction.size, FUNCTIONS))
    for i in range(wave_number.size):
        for j in range(direction.size):
            surge, sway, heave, roll, pitch, yaw = box_response(
                box, wave_number[i], math.cos(direction[j]), math.sin(direction[j])
            )
            # a Re[X exp(i theta)] = a (Re X cos(theta) - Im X sin(theta))
            values[i, j, SURGE_IM] = -surge
            values[i, j, SWAY_IM] = -sway
            values[i, j, HEAVE_RE] = heave
            values[i, j, ROLL_IM] = -roll
            values[i, j, PITCH_IM] = -pitch
            values[i, j, YAW_RE] = yaw
    return values
