"""Low-frequency motion of the hull in surge, sway and yaw, in a uniform current."""

from __future__ import annotations

import numpy as np

from marine_model.errors import InputError
from marine_model.vessel import Vessel

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

    Scalars instead of arrays: the functions run some hundred times per simulated second on three numbers.

    Raises
    ------
    InputError
        If the time step of the vessel is too long for the damping of its hull.
    """

    def __init__(self, vessel: Vessel) -> None:
        data = vessel.manoeuvring
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
        self._mass: tuple[float, ...] = tuple(mass.ravel().tolist())
        self._inverse: tuple[float, ...] = tuple(inverse.ravel().tolist())
        self._damping: tuple[float, ...] = tuple(damping.ravel().tolist())
        self._quadratic = tuple(data.quadratic_damping)

    def hydrodynamic_force(self, u: float, v: float, r: float) -> Triple:
        """Return -(C(nu_r) nu_r + D nu_r + D_q |nu_r| nu_r): N, N, N m in the body frame.

        Parameters
        ----------
        u, v, r
            Velocity through the water in the body frame, m/s, m/s, rad/s.
        """
        m11, m12, m13, m21, m22, m23, _, _, _ = self._mass
        d11, d12, d13, d21, d22, d23, d31, d32, d33 = self._damping
        q1, q2, q3 = self._quadratic
        p1 = m11 * u + m12 * v + m13 * r
        p2 = m21 * u + m22 * v + m23 * r
        return (
            p2 * r - (d11 + q1 * abs(u)) * u - d12 * v - d13 * r,
            -p1 * r - d21 * u - (d22 + q2 * abs(v)) * v - d23 * r,
            p1 * v - p2 * u - d31 * u - d32 * v - (d33 + q3 * abs(r)) * r,
        )

    def acceleration(self, u: float, v: float, r: float, x: float, y: float, n: float) -> Triple:
        """Return nu_r_dot (m/s^2, m/s^2, rad/s^2) under the generalized force (x, y, n) (N, N, N m)."""
        i11, i12, i13, i21, i22, i23, i31, i32, i33 = self._inverse
        hx, hy, hn = self.hydrodynamic_force(u, v, r)
        x += hx
        y += hy
        n += hn
        return (
            i11 * x + i12 * y + i13 * n,
            i21 * x + i22 * y + i23 * n,
            i31 * x + i32 * y + i33 * n,
        )

    def kinetic_energy(self, u: float, v: float, r: float) -> float:
        """Return the energy (J) of hull and entrained water in the frame of the water."""
        m11, m12, m13, m21, m22, m23, m31, m32, m33 = self._mass
        return 0.5 * (
            u * (m11 * u + m12 * v + m13 * r) + v * (m21 * u + m22 * v + m23 * r) + r * (m31 * u + m32 * v + m33 * r)
        )
