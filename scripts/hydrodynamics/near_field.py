"""Mean second-order force on a hull held fast, from the pressure on it: an independent check of the far field.

Good in head seas. In beam seas the velocity at the bilge, where it is large, makes it converge slowly with the panels.

In units of L, rho and g, with n out of the hull, v the velocity and zeta the elevation of the waves there:

    F = 1/4 integral |v|^2 n dS - 1/4 integral |zeta|^2 n dl,     dl along the waterline, n there in its plane
"""

from __future__ import annotations

import capytaine as cpt
import numpy as np

from hydrodynamics.body import Hull
from hydrodynamics.hull_form import Array


def fixed_hull_force(solver: cpt.BEMSolver, hull: Hull, frequency: float, direction: float) -> Array:
    """Return X, Y in capytaine's axes in waves of unit amplitude that travel in ``direction`` (rad)."""
    problem = cpt.DiffractionProblem(
        body=hull.body, omega=frequency, wave_direction=direction, rho=1.0, g=1.0, water_depth=np.inf
    )
    found = solver.solve(problem, _check_wavelength=False)
    mesh = hull.body.mesh
    centres, normals, areas = mesh.faces_centers, mesh.faces_normals, mesh.faces_areas
    flow = cpt.bem.airy_waves.airy_waves_velocity(centres, problem) + solver.compute_velocity(centres, found)
    # Nothing goes through the hull; on it, the sources make the normal velocity jump.
    flow = flow - np.einsum("pi,pi->p", flow, normals)[:, None] * normals
    dynamic = 0.25 * np.sum(np.abs(flow) ** 2, axis=1) * areas @ normals[:, :2]

    potential = cpt.bem.airy_waves.airy_waves_potential(centres, problem) + found.potential[hull.body.hull_mask]
    force = np.array(dynamic)
    for face, panel in enumerate(_corners(mesh)):
        ends = np.unique(panel[np.abs(panel[:, 2]) < 1e-9].round(12), axis=0)
        if len(ends) != 2:
            continue
        along = ends[1] - ends[0]
        outward = np.array([along[1], -along[0]])
        outward *= np.sign(outward @ normals[face, :2])
        # From the centre of the panel to the surface, where d phi / d z = k phi.
        elevation = frequency * potential[face] * np.exp(-(frequency**2) * centres[face, 2])
        force -= 0.25 * np.abs(elevation) ** 2 * outward
    return force


def _corners(mesh: cpt.ReflectionSymmetricMesh) -> Array:
    """Return the corners of all panels, shape (panels, 4, 3): of a quarter that is mirrored to starboard, then aft."""
    quarter = mesh.half.half
    corners = quarter.vertices[quarter.faces]
    signs = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]])
    return np.concatenate([corners * sign for sign in signs])
