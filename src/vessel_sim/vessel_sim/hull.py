"""Low-frequency motion of the hull in surge, sway and yaw, in a uniform current."""

from __future__ import annotations

import numpy as np

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel

# Where in the coefficients what begins: matrices row by row.
MASS, INVERSE, DAMPING, QUADRATIC = 0, 9, 18, 27

Triple = tuple[float, float, float]

# Heun's method is stable up to 2 on the negative real axis; a tenth of it keeps the error of one time constant
# of decay below 1 %.
_STEP_TIMES_RATE_MAX = 0.2


class Hull:
    """Manoeuvring model in the frame of the water.

    With nu_r the velocity through the water, resolved in the body frame,

        (M_RB + M_A) nu_r_dot + C(nu_r) nu_r + D nu_r + D_q |nu_r| nu_r = tau,

    where C(nu_r) nu_r = [-p_2 r, p_1 r, p_2 u - p_1 v] with momentum p = (M_RB + M_A) nu_r (Fossen, Coriolis and
    centripetal terms of rigid body and added mass together; nu^T C nu = 0). In a current that is constant and
    irrotational the frame of the water is an inertial frame, so that this holds for the rigid-body part too.

    Attributes
    ----------
    coefficients
        M_RB + M_A, its inverse, D, D_q, as the compiled functions take them, shape (30,).

    Raises
    ------
    InputError
        If the time step of the vessel is too long for the damping of its hull.
    """

    def __init__(self, vessel: Vessel) -> None:
        data, _ = vessel.on_surface()
        mass = np.array(data.rigid_body_mass) + np.array(data.added_mass)
        damping = np.array(data.linear_damping)
        inverse = np.linalg.inv(mass)
        fastest = float(np.abs(np.linalg.eigvals(inverse @ damping)).max())
        time_step = vessel.simulation.time_step
        if time_step * fastest > _STEP_TIMES_RATE_MAX:
            raise InputError(
                f"simulation.time_step: expected at most {_STEP_TIMES_RATE_MAX / fastest:.3g} s, "
                f"{_STEP_TIMES_RATE_MAX} of the shortest time constant of the hull, found {time_step} s"
            )
        self.coefficients: FloatArray = np.concatenate(
            [mass.ravel(), inverse.ravel(), damping.ravel(), np.array(data.quadratic_damping)]
        )

    def hydrodynamic_force(self, u: float, v: float, r: float) -> Triple:
        """Return -(C(nu_r) nu_r + D nu_r + D_q |nu_r| nu_r): N, N, N m in the body frame.

        Parameters
        ----------
        u, v, r
            Velocity through the water in the body frame, m/s, m/s, rad/s.
        """
        return hydrodynamic_force(self.coefficients, u, v, r)

    def acceleration(self, u: float, v: float, r: float, x: float, y: float, n: float) -> Triple:
        """Return nu_r_dot (m/s^2, m/s^2, rad/s^2) under the generalized force (x, y, n) (N, N, N m)."""
        return acceleration(self.coefficients, u, v, r, x, y, n)

    def kinetic_energy(self, u: float, v: float, r: float) -> float:
        """Return the energy (J) of hull and entrained water in the frame of the water."""
        velocity = np.array([u, v, r])
        mass = self.coefficients[MASS:INVERSE].reshape(3, 3)
        return float(0.5 * velocity @ mass @ velocity)


@compiled
def hydrodynamic_force(hull: FloatArray, u: float, v: float, r: float) -> Triple:
    """Return what ``Hull.hydrodynamic_force`` does; ``hull`` are its ``coefficients``."""
    p1 = hull[MASS] * u + hull[MASS + 1] * v + hull[MASS + 2] * r
    p2 = hull[MASS + 3] * u + hull[MASS + 4] * v + hull[MASS + 5] * r
    d = DAMPING
    q1, q2, q3 = hull[QUADRATIC], hull[QUADRATIC + 1], hull[QUADRATIC + 2]
    return (
        p2 * r - (hull[d] + q1 * abs(u)) * u - hull[d + 1] * v - hull[d + 2] * r,
        -p1 * r - hull[d + 3] * u - (hull[d + 4] + q2 * abs(v)) * v - hull[d + 5] * r,
        p1 * v - p2 * u - hull[d + 6] * u - hull[d + 7] * v - (hull[d + 8] + q3 * abs(r)) * r,
    )


@compiled
def acceleration(hull: FloatArray, u: float, v: float, r: float, x: float, y: float, n: float) -> Triple:
    """Return what ``Hull.acceleration`` does; ``hull`` are its ``coefficients``."""
    hx, hy, hn = hydrodynamic_force(hull, u, v, r)
    x += hx
    y += hy
    n += hn
    i = INVERSE
    return (
        hull[i] * x + hull[i + 1] * y + hull[i + 2] * n,
        hull[i + 3] * x + hull[i + 4] * y + hull[i + 5] * n,
        hull[i + 6] * x + hull[i + 7] * y + hull[i + 8] * n,
    )
