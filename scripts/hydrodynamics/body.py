"""The hull as a rigid body, in units of its length L, the density of water and the acceleration of gravity.

Axes are capytaine's: x ahead, y to port, z up, origin midships in the waterline.
"""

from __future__ import annotations

from dataclasses import dataclass

import capytaine as cpt
import numpy as np

from hydrodynamics.hull_form import Array, HullForm
from hydrodynamics.mesh import fitted, hull_and_lid

# What the sources do not print. Usual values for offshore vessels.
RADIUS_ROLL = 0.35  # of the beam, without added mass
RADIUS_PITCH = 0.25  # of the length
RADIUS_YAW = 0.25  # of the length
METACENTRIC_HEIGHT = 0.1  # of the beam
VISCOUS_ROLL = 0.05  # of critical damping: bilge vortices and friction, which potential flow leaves out

HEAVE, ROLL, PITCH = 2, 3, 4


@dataclass(frozen=True)
class Hull:
    """What floats.

    Parameters
    ----------
    form
        The hull form.
    body
        Its panels, with six rigid modes about the origin and a lid.
    mass
        Of the body with its centre of gravity, shape (6, 6).
    stiffness
        Hydrostatic, shape (6, 6).
    centre_of_gravity
        Height above the waterline.
    """

    form: HullForm
    body: cpt.FloatingBody
    mass: Array
    stiffness: Array
    centre_of_gravity: float

    @classmethod
    def of(cls, length: float, beam: float, draught: float, volume: float, panel: float) -> Hull:
        """Return the hull with panels of side ``panel``, in lengths of the ship; the rest in m and m^3."""
        beam, draught, volume = beam / length, draught / length, volume / length**3
        form = fitted(HullForm.of(1.0, beam, draught, volume), panel, volume)
        hull, lid = hull_and_lid(form, panel)
        body = cpt.FloatingBody(mesh=hull, lid_mesh=lid, dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)))
        area, x, y = lid.faces_areas, lid.faces_centers[:, 0], lid.faces_centers[:, 1]
        buoyancy = _height_of_buoyancy(hull, volume)
        # The metacentre is above the centre of buoyancy by the second moment of the waterplane over the volume.
        gravity = buoyancy + float(np.sum(area * y**2)) / volume - METACENTRIC_HEIGHT * beam
        stiffness = np.zeros((6, 6))
        stiffness[HEAVE, HEAVE] = np.sum(area)
        stiffness[ROLL, ROLL] = volume * METACENTRIC_HEIGHT * beam
        stiffness[PITCH, PITCH] = np.sum(area * x**2) + volume * (buoyancy - gravity)
        return cls(form, body, _mass(volume, beam, gravity), stiffness, gravity)


def _height_of_buoyancy(hull: cpt.ReflectionSymmetricMesh, volume: float) -> float:
    z = hull.faces_centers[:, 2]
    return float(np.sum(0.5 * z**2 * hull.faces_normals[:, 2] * hull.faces_areas)) / volume


def _mass(mass: float, beam: float, height: float) -> Array:
    """Return the mass matrix about the origin of a body whose centre of gravity is ``height`` above it."""
    radii = np.array([RADIUS_ROLL * beam, RADIUS_PITCH, RADIUS_YAW])
    arm = np.array([[0.0, -height, 0.0], [height, 0.0, 0.0], [0.0, 0.0, 0.0]])  # r x, for r = (0, 0, height)
    matrix = mass * np.eye(6)
    matrix[:3, 3:], matrix[3:, :3] = -mass * arm, mass * arm
    matrix[3:, 3:] = mass * (np.diag(radii**2) - arm @ arm)
    return matrix
