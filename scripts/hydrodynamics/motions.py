"""Motion of the free hull at zero speed."""

from __future__ import annotations

import numpy as np

from hydrodynamics.body import ROLL, VISCOUS_ROLL, Hull
from hydrodynamics.hull_form import Array
from hydrodynamics.solve import ComplexArray, Flow

# From capytaine's axes (y to port, z up) to the body axes (y to starboard, z down).
TO_BODY: Array = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])


def motion(hull: Hull, flow: Flow, viscous_roll: float) -> ComplexArray:
    """Return the motion in waves of unit amplitude, capytaine's axes, shape (nh, 6).

    ``viscous_roll`` is the damping that is added to roll, in units of L, rho and g.
    """
    omega = flow.frequency
    damping = flow.damping.copy()
    damping[ROLL, ROLL] += viscous_roll
    impedance = hull.stiffness - omega**2 * (hull.mass + flow.added_mass) - 1j * omega * damping
    moved: ComplexArray = np.linalg.solve(impedance, flow.excitation.T).T.astype(np.complex128)
    return moved


def viscous_roll(hull: Hull, added_mass: float, share: float = VISCOUS_ROLL) -> float:
    """Return ``share`` of critical roll damping, with the added mass at the resonance."""
    inertia = hull.mass[ROLL, ROLL] + added_mass
    return float(2.0 * share * np.sqrt(hull.stiffness[ROLL, ROLL] * inertia))
