"""A submerged body in six degrees of freedom: the forces of water and gravity on it."""

from __future__ import annotations

import numpy as np

from marine_model.compiled import compiled
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray, positive_number
from marine_model.underwater import UnderwaterBody
from vessel_sim.underwater.columns import (
    BUOYANCY,
    BUOYANCY_CENTRE,
    DEPTH,
    FIN_HEAVE,
    FIN_RADIUS,
    FIN_SWAY,
    FIN_X,
    GRAVITY_CENTRE,
    HEIGHT,
    INVERSE,
    LINEAR,
    MASS,
    QUADRATIC,
    QUATERNION,
    RIGID,
    VELOCITY,
    WEIGHT,
)

# The classical Runge-Kutta method is stable up to 2.8 on either axis; at a fifth of that its error in a time constant
# of decay is below 1e-3.
_STEP_TIMES_RATE_MAX = 0.56


class SubmergedBody:
    """Fossen's model of an underwater vehicle, in the frame of the water.

    With nu_r the velocity through the water, all six components in the body frame,

        (M_RB + M_A) nu_r_dot + C(nu_r) nu_r + D nu_r + D_q |nu_r| nu_r + f(nu_r) + g(attitude, depth) = tau.

    C(nu_r) nu_r = [w x p_1, w x p_2 + v x p_1] with nu_r = (v, w) and momentum (p_1, p_2) = (M_RB + M_A) nu_r:
    Coriolis and centripetal terms of rigid body and added mass together (Kirchhoff; nu^T C nu = 0). In a current that
    is constant and irrotational the frame of the water is an inertial frame, so that this holds for the rigid-body
    part too.

    f is the lift of fixed fins at x, at a radius R from the axis: a force k_y |u| (v + x r) to port and one of
    k_z |u| (w - x q) up, both at x, and a moment (k_y + k_z) R^2 |u| p against the roll. It opposes the motion across
    the fins, so that it takes energy out, as damping does.

    -g is the weight W in the centre of gravity and the buoyancy s B in the centre of buoyancy, of which s is what is
    below the surface: s = clamp(1/2 + z_b / H, 0, 1), with z_b the depth of the centre of buoyancy and H the height of
    the body. It is a box with vertical walls that comes out of calm water; nothing else changes there.

    Parameters
    ----------
    data
        Section ``underwater`` of the vessel.
    mass
        kg.
    height
        H, m.

    Attributes
    ----------
    coefficients
        As the compiled functions take them; see ``columns``.
    """

    def __init__(self, data: UnderwaterBody, mass: float, height: float) -> None:
        fins = data.fins
        total = data.total_mass(positive_number("mass", mass))
        self._righting = data.righting_moment(mass)
        self.coefficients: FloatArray = np.concatenate(
            [
                total.ravel(),
                np.linalg.inv(total).ravel(),
                np.array(data.linear_damping),
                np.array(data.quadratic_damping),
                [mass * GRAVITY, data.buoyancy],
                np.array(data.centre_of_gravity),
                np.array(data.centre_of_buoyancy),
                [positive_number("height", height)],
                [0.0] * 4 if fins is None else [fins.x, fins.radius, fins.sway, fins.heave],
            ]
        )

    def check_time_step(self, time_step: float, force_max: FloatArray) -> None:
        """Refuse a time step (s) that is too long for this body.

        Parameters
        ----------
        time_step
            s.
        force_max
            Largest force of the thrusters along, or about, every axis, shape (6,): at the speed that it gives the
            quadratic damping is linearised.

        Raises
        ------
        InputError
            If it is longer than a fifth of what is stable for the fastest swing or decay.
        """
        data = self.coefficients
        linear, quadratic = data[LINEAR:QUADRATIC], data[QUADRATIC:WEIGHT]
        # Of d v + q v^2 = F, in a form that is good for q = 0.
        root = np.sqrt(linear**2 + 4.0 * quadratic * force_max)
        speed = np.divide(2.0 * force_max, linear + root, out=np.zeros(6), where=linear + root > 0.0)
        x, radius, upright, lying = data[FIN_X : FIN_HEAVE + 1]
        rolling, turning = radius**2 * (upright + lying), x**2 * np.array([lying, upright])
        fins = speed[0] * np.array([0.0, upright, lying, rolling, *turning])
        inverse = data[INVERSE:LINEAR].reshape(6, 6)
        system = np.zeros((12, 12))
        system[:6, 6:] = np.eye(6)
        system[6:, :6] = -inverse @ np.diag([0.0, 0.0, data[BUOYANCY] / data[HEIGHT], *(self._righting,) * 2, 0.0])
        system[6:, 6:] = -inverse @ np.diag(linear + 2.0 * quadratic * speed + fins)
        fastest = float(np.abs(np.linalg.eigvals(system)).max())
        if time_step * fastest > _STEP_TIMES_RATE_MAX:
            raise InputError(
                f"simulation.time_step: expected at most {_STEP_TIMES_RATE_MAX / fastest:.3g} s, a fifth of what is "
                f"stable for the fastest motion of the body, {fastest:.3g} rad/s, found {time_step} s"
            )

    def hydrodynamic_force(self, velocity: FloatArray) -> FloatArray:
        """Return -(C(nu_r) nu_r + D nu_r + D_q |nu_r| nu_r + f(nu_r)), shape (6,): N and N m in the body frame."""
        force = np.empty(6)
        hydrodynamic_force(self.coefficients, velocity, force)
        return force

    def restoring_force(self, motion: FloatArray) -> FloatArray:
        """Return -g, shape (6,): N and N m in the body frame; ``motion`` is that of ``columns``."""
        force = np.zeros(6)
        add_restoring_force(self.coefficients, motion, force)
        return force

    def energy(self, motion: FloatArray) -> float:
        """Return kinetic energy in the frame of the water, with that of entrained water, and potential energy, J.

        The potential is zero for an upright body with its origin at depth 0, as far as weight and full buoyancy go.
        """
        data = self.coefficients
        velocity = motion[VELOCITY : VELOCITY + 6]
        kinetic = 0.5 * velocity @ data[MASS:INVERSE].reshape(6, 6) @ velocity
        down = np.array(down_in_body(motion))
        depth_g = motion[DEPTH] + down @ data[GRAVITY_CENTRE : GRAVITY_CENTRE + 3]
        depth_b = motion[DEPTH] + down @ data[BUOYANCY_CENTRE : BUOYANCY_CENTRE + 3]
        # Integral of the share below the surface over depth: 0 above, a parabola on the way, then straight on.
        height = data[HEIGHT]
        wet = min(max(depth_b + 0.5 * height, 0.0), height)
        lifted = wet**2 / (2.0 * height) + max(depth_b - 0.5 * height, 0.0)
        return float(kinetic - data[WEIGHT] * depth_g + data[BUOYANCY] * lifted)


@compiled
def down_in_body(motion: FloatArray) -> tuple[float, float, float]:
    """Return the unit vector down, in the body frame."""
    w, x, y, z = motion[QUATERNION], motion[QUATERNION + 1], motion[QUATERNION + 2], motion[QUATERNION + 3]
    scale = 2.0 / (w * w + x * x + y * y + z * z)
    return scale * (x * z - w * y), scale * (y * z + w * x), 1.0 - scale * (x * x + y * y)


@compiled
def hydrodynamic_force(body: FloatArray, velocity: FloatArray, force: FloatArray) -> None:
    """Write what ``SubmergedBody.hydrodynamic_force`` returns into ``force``; ``body`` are its ``coefficients``."""
    momentum = np.empty(6)
    for i in range(6):
        total = 0.0
        for j in range(6):
            total += body[MASS + 6 * i + j] * velocity[j]
        momentum[i] = total
    u, v, w, p, q, r = velocity[0], velocity[1], velocity[2], velocity[3], velocity[4], velocity[5]
    a, b, c, d, e, f = momentum[0], momentum[1], momentum[2], momentum[3], momentum[4], momentum[5]
    force[0] = r * b - q * c
    force[1] = p * c - r * a
    force[2] = q * a - p * b
    force[3] = r * e - q * f + w * b - v * c
    force[4] = p * f - r * d + u * c - w * a
    force[5] = q * d - p * e + v * a - u * b
    for i in range(6):
        force[i] -= (body[LINEAR + i] + body[QUADRATIC + i] * abs(velocity[i])) * velocity[i]
    x = body[FIN_X]
    to_port = body[FIN_SWAY] * abs(u) * (v + x * r)
    up = body[FIN_HEAVE] * abs(u) * (w - x * q)
    force[1] -= to_port
    force[2] -= up
    force[3] -= (body[FIN_SWAY] + body[FIN_HEAVE]) * body[FIN_RADIUS] ** 2 * abs(u) * p
    force[4] += x * up
    force[5] -= x * to_port


@compiled
def add_restoring_force(body: FloatArray, motion: FloatArray, force: FloatArray) -> None:
    """Add what ``SubmergedBody.restoring_force`` returns to ``force``; ``body`` are its ``coefficients``."""
    x, y, z = down_in_body(motion)
    g, b = GRAVITY_CENTRE, BUOYANCY_CENTRE
    depth = motion[DEPTH] + x * body[b] + y * body[b + 1] + z * body[b + 2]
    weight = body[WEIGHT]
    lift = min(max(0.5 + depth / body[HEIGHT], 0.0), 1.0) * body[BUOYANCY]
    force[0] += (weight - lift) * x
    force[1] += (weight - lift) * y
    force[2] += (weight - lift) * z
    arm_x = weight * body[g] - lift * body[b]
    arm_y = weight * body[g + 1] - lift * body[b + 1]
    arm_z = weight * body[g + 2] - lift * body[b + 2]
    force[3] += arm_y * z - arm_z * y
    force[4] += arm_z * x - arm_x * z
    force[5] += arm_x * y - arm_y * x


@compiled
def rate_of_change(
    body: FloatArray, motion: FloatArray, force: FloatArray, current: tuple[float, float], rate: FloatArray
) -> None:
    """Write the rate of change of ``motion[:RIGID]`` into ``rate``, shape (RIGID,).

    Parameters
    ----------
    body
        ``SubmergedBody.coefficients``.
    motion
        See ``columns``; only what comes before ``RIGID`` counts.
    force
        Of the thrusters, N and N m in the body frame, shape (6,).
    current
        North, east, m/s.
    rate
        Is written into.
    """
    w, x, y, z = motion[QUATERNION], motion[QUATERNION + 1], motion[QUATERNION + 2], motion[QUATERNION + 3]
    velocity = motion[VELOCITY:RIGID]
    u, v, s, p, q, r = velocity[0], velocity[1], velocity[2], velocity[3], velocity[4], velocity[5]
    scale = 2.0 / (w * w + x * x + y * y + z * z)
    rate[0] = (1.0 - scale * (y * y + z * z)) * u + scale * ((x * y - w * z) * v + (x * z + w * y) * s) + current[0]
    rate[1] = (1.0 - scale * (x * x + z * z)) * v + scale * ((x * y + w * z) * u + (y * z - w * x) * s) + current[1]
    rate[2] = (1.0 - scale * (x * x + y * y)) * s + scale * ((x * z - w * y) * u + (y * z + w * x) * v)
    rate[3] = -0.5 * (x * p + y * q + z * r)
    rate[4] = 0.5 * (w * p + y * r - z * q)
    rate[5] = 0.5 * (w * q + z * p - x * r)
    rate[6] = 0.5 * (w * r + x * q - y * p)
    total = np.empty(6)
    hydrodynamic_force(body, velocity, total)
    add_restoring_force(body, motion, total)
    for i in range(6):
        total[i] += force[i]
    for i in range(6):
        acceleration = 0.0
        for j in range(6):
            acceleration += body[INVERSE + 6 * i + j] * total[j]
        rate[VELOCITY + i] = acceleration
