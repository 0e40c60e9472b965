"""Radiation and diffraction in deep water, and what of the waves that go out reaches the far field."""

from __future__ import annotations

from dataclasses import dataclass

import capytaine as cpt
import numpy as np
from numpy.typing import NDArray

from hydrodynamics.body import Hull
from hydrodynamics.hull_form import Array

ComplexArray = NDArray[np.complex128]

MODES = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")

# Directions of the far field: as many as a degree apart. The Kochin function of a ship has some k L / 2 waves round the
# circle, 25 at omega sqrt(L / g) = 7, so that sums over them are integrals to rounding.
DIRECTIONS: Array = np.radians(np.arange(360.0))


@dataclass(frozen=True)
class Flow:
    """Solution at one frequency, in units of L, rho and g, capytaine's axes and phases exp(-i omega t).

    Parameters
    ----------
    frequency
        omega.
    added_mass, damping
        Shape (6, 6).
    excitation
        Force of waves of unit amplitude on the fixed hull, shape (nh, 6).
    radiated, diffracted
        Kochin functions at ``DIRECTIONS``, of unit motion in every mode, shape (6, nd), and of the waves that
        the fixed hull scatters, shape (nh, nd).
    """

    frequency: float
    added_mass: Array
    damping: Array
    excitation: ComplexArray
    radiated: ComplexArray
    diffracted: ComplexArray


def solve(solver: cpt.BEMSolver, hull: Hull, frequency: float, directions: Array) -> Flow:
    """Return the flow at one frequency for waves that travel in ``directions`` (rad from x to y, whole degrees)."""
    water = {"body": hull.body, "omega": frequency, "rho": 1.0, "g": 1.0, "water_depth": np.inf}
    radiation = [
        solver.solve(cpt.RadiationProblem(radiating_dof=mode, **water), _check_wavelength=False) for mode in MODES
    ]
    diffraction = [
        solver.solve(cpt.DiffractionProblem(wave_direction=float(angle), **water), _check_wavelength=False)
        for angle in directions
    ]
    sources = np.array([result.sources for result in (*radiation, *diffraction)])
    kochin = sources @ _far_field(hull, frequency**2).T
    excitation = np.array([_excitation(found) for found in diffraction])
    return Flow(
        frequency,
        np.array([[found.added_masses[m] for found in radiation] for m in MODES]),
        np.array([[found.radiation_dampings[m] for found in radiation] for m in MODES]),
        excitation,
        kochin[:6],
        kochin[6:],
    )


def zero_frequency_added_mass(hull: Hull) -> Array:
    """Return the added mass in slow motion, in which the surface stays flat, shape (6, 6)."""
    solver = cpt.BEMSolver()
    bare = cpt.FloatingBody(mesh=hull.body.mesh, dofs=hull.body.dofs)
    found = [
        solver.solve(cpt.RadiationProblem(body=bare, radiating_dof=mode, omega=0.0, rho=1.0, g=1.0)) for mode in MODES
    ]
    return np.array([[result.added_masses[m] for result in found] for m in MODES])


def _excitation(found: cpt.DiffractionResult) -> list[complex]:
    undisturbed = cpt.bem.airy_waves.froude_krylov_force(found.problem)
    return [undisturbed[mode] + found.forces[mode] for mode in MODES]


def _far_field(hull: Hull, wave_number: float) -> ComplexArray:
    """Return what a source on every panel adds to the Kochin function, shape (nd, panels): as capytaine's."""
    mesh = hull.body.mesh_including_lid
    x, y, z = mesh.faces_centers.T
    along = np.outer(np.cos(DIRECTIONS), x) + np.outer(np.sin(DIRECTIONS), y)
    reach: ComplexArray = np.exp(wave_number * (z - 1j * along)) * mesh.faces_areas / (4.0 * np.pi)
    return reach
