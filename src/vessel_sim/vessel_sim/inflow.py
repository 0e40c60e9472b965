"""Water at the thrusters: submergence of their shafts and speed of advance."""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.waves.at_ship import Waves
from vessel_sim.waves.components import COS_BETA, OMEGA, PHASE, SIN_BETA, WAVE_NUMBER, local_amplitude
from vessel_sim.waves.hull_motion import Triple, hull_motion

# Columns of the table of thrusters.
X = 0  # m ahead of the origin
Y = 1  # m to starboard
DEPTH = 2  # m of the shaft below the calm surface


class Inflow:
    """Submergence and speed of advance of every thruster of a vessel.

    With the first-order motion of the hull in the body axes (heave down, pitch bow up, roll starboard down), the shaft
    of thruster j moves down by heave - x_j pitch + y_j roll, and lies below the surface over it by

        h_j = depth_j + elevation_j + heave - x_j pitch + y_j roll.

    The speed of advance is the velocity of thruster j through the water in the direction of its azimuth, the
    direction of its force on the vessel. The velocity is that of the hull through the water, of low
    frequency and of the waves, rotations included, less the orbital velocity of the water at the shaft:

        V_A,j = (u + u_w + z_j q_w - (r + r_w) y_j - w_x,j) cos alpha_j
              + (v + v_w - z_j p_w + (r + r_w) x_j - w_y,j) sin alpha_j.

    Waves are taken at the low-frequency place of the thruster and at the depth of its shaft at rest, as linear theory
    has it. Wake of the hull, wash of other thrusters and inflow across the shaft are left out.

    Parameters
    ----------
    vessel
        Hull and thrusters.

    Attributes
    ----------
    thrusters
        What the compiled function ``inflow`` takes, shape (n, 3).
    """

    def __init__(self, vessel: Vessel) -> None:
        self.thrusters: FloatArray = np.ascontiguousarray(
            np.column_stack([vessel.lever_x, vessel.lever_y, vessel.shaft_depth])
        )

    def decay(self, components: FloatArray) -> FloatArray:
        """Return how much of the motion of the water is left at the depth of every shaft, shape (m, n).

        At most 1: see ``components.particle_velocity``.
        """
        return np.exp(-components[:, [WAVE_NUMBER]] * np.maximum(0.0, self.thrusters[:, DEPTH]))

    def at(
        self,
        position: Triple,
        relative_velocity: Triple,
        azimuth: FloatArray,
        waves: Waves,
        time: float,
        current: tuple[float, float] = (0.0, 0.0),
    ) -> tuple[FloatArray, FloatArray]:
        """Return submergence of the shafts (m, negative above the surface) and speed of advance (m/s), shape (n,).

        Numbers are not checked here.

        Parameters
        ----------
        position
            Low-frequency position: north (m), east (m), heading (rad).
        relative_velocity
            Low-frequency velocity through the water, body frame: m/s, m/s, rad/s.
        azimuth
            rad, float64, shape (n,).
        waves
            The sea at the vessel.
        time
            s.
        current
            North, east, m/s; the frequency of encounter goes with the velocity over ground.
        """
        components = waves.components
        return inflow(
            components,
            waves.response,
            self.decay(components),
            self.thrusters,
            position,
            relative_velocity,
            current,
            azimuth,
            time,
        )


@compiled
def inflow(
    components: FloatArray,
    response: FloatArray,
    decay: FloatArray,
    thrusters: FloatArray,
    position: Triple,
    relative_velocity: Triple,
    current: tuple[float, float],
    azimuth: FloatArray,
    time: float,
) -> tuple[FloatArray, FloatArray]:
    """Return what ``Inflow.at`` does; ``thrusters`` has a row (x, y, depth of the shaft) for each."""
    north, east, heading = position
    u, v, r = relative_velocity
    c, s = math.cos(heading), math.sin(heading)
    over_ground = (c * u - s * v + current[0], s * u + c * v + current[1])
    moved, rate = hull_motion(components, response, position, over_ground, time)
    turn = r + rate[5]
    n = thrusters.shape[0]
    submergence, advance = np.empty(n), np.empty(n)
    for j in range(n):
        x, y, depth = thrusters[j, X], thrusters[j, Y], thrusters[j, DEPTH]
        at_north, at_east = north + c * x - s * y, east + s * x + c * y
        surface = water_north = water_east = 0.0
        for i in range(components.shape[0]):
            along = at_north * components[i, COS_BETA] + at_east * components[i, SIN_BETA]
            a, growth = local_amplitude(components, i, along, time)
            if a == 0.0 and growth == 0.0:
                continue
            theta = components[i, WAVE_NUMBER] * along - components[i, OMEGA] * time + components[i, PHASE]
            sin_t, cos_t = math.sin(theta), math.cos(theta)
            surface += a * cos_t
            # As components.particle_velocity, horizontally.
            forward = decay[i, j] * (a * components[i, OMEGA] * cos_t - growth * sin_t)
            water_north += forward * components[i, COS_BETA]
            water_east += forward * components[i, SIN_BETA]
        submergence[j] = depth + surface + moved[2] - x * moved[4] + y * moved[3]
        ahead = u + rate[0] + depth * rate[4] - turn * y - (c * water_north + s * water_east)
        to_starboard = v + rate[1] - depth * rate[3] + turn * x - (c * water_east - s * water_north)
        advance[j] = ahead * math.cos(azimuth[j]) + to_starboard * math.sin(azimuth[j])
    return submergence, advance
