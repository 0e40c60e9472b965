"""Response of one hull over all frequencies and headings, in the body axes of the project."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import capytaine as cpt
import numpy as np

from hydrodynamics.body import ROLL, Hull
from hydrodynamics.drift import drift, lost, spent
from hydrodynamics.hull_form import Array
from hydrodynamics.motions import TO_BODY, motion, viscous_roll
from hydrodynamics.solve import ComplexArray, Flow, solve, zero_frequency_added_mass

# From the stern to the beam. Bow and stern are alike, so that the rest follows.
HEADINGS: Array = np.radians(np.arange(0.0, 91.0, 5.0))
MIRRORED: Array = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])


@dataclass(frozen=True)
class Response:
    """What goes into a data file, without dimensions (``marine_model.wave_response.WaveResponse``), and how it came.

    Parameters
    ----------
    frequency, heading, motion, drift
        As in the data file.
    slow_added_mass
        In slow motion: surge, sway, yaw, body axes, units of rho and L, shape (3, 3).
    roll_frequency
        Natural frequency of roll.
    energy_error
        Difference of the two forms of E (``hydrodynamics.drift``) over B / L, shape (nf, nh).
    """

    frequency: Array
    heading: Array
    motion: ComplexArray
    drift: Array
    slow_added_mass: Array
    roll_frequency: float
    energy_error: Array

    def all_round(self) -> Response:
        """Return the response from b = 0 to pi of one from 0 to pi / 2, for a hull whose bow and stern are alike.

        Seen in a mirror across the ship, waves from the bow come from the stern, and surge, pitch and yaw change sign.
        """
        return replace(
            self,
            heading=np.concatenate([self.heading, np.pi - self.heading[-2::-1]]),
            motion=np.concatenate([self.motion, self.motion[:, -2::-1] * MIRRORED], axis=1),
            drift=np.concatenate([self.drift, self.drift[:, -2::-1] * MIRRORED[[0, 1, 5]]], axis=1),
        )


def base_frequencies() -> Array:
    """Return omega sqrt(L / g): 0.1 apart where hulls resonate and where diffraction sets in, wider outside."""
    return np.concatenate([[0.3, 0.5, 0.7, 0.85], np.linspace(1.0, 4.5, 36), np.linspace(4.75, 7.0, 10)])


def natural_roll_frequency(solver: cpt.BEMSolver, hull: Hull) -> float:
    """Return the frequency at which roll, uncoupled, resonates."""
    omega = 1.5
    for _ in range(4):  # the added mass hardly depends on the frequency: a step leaves some hundredth of the error
        problem = cpt.RadiationProblem(body=hull.body, radiating_dof="Roll", omega=omega, rho=1.0, g=1.0)
        added = solver.solve(problem, _check_wavelength=False).added_masses["Roll"]
        omega = float(np.sqrt(hull.stiffness[ROLL, ROLL] / (hull.mass[ROLL, ROLL] + added)))
    return omega


def frequencies(roll: float) -> Array:
    """Return all frequencies, with more of them around the resonance of roll."""
    return np.unique(np.concatenate([base_frequencies(), roll * np.linspace(0.88, 1.12, 9)]).round(4))


def respond(hull: Hull, wanted: Array | None, heading: Array, progress: Callable[[int, int], None]) -> Response:
    """Compute the response at ``wanted`` frequencies (those above if None) and ``heading`` (rad, whole degrees)."""
    solver = cpt.BEMSolver()
    roll = natural_roll_frequency(solver, hull)
    omega = frequencies(roll) if wanted is None else wanted
    # What travels to starboard in the body axes travels to -y in capytaine's.
    directions = -heading
    flows = []
    for i, w in enumerate(omega):
        progress(i, len(omega))
        flows.append(solve(solver, hull, float(w), directions))
    added = float(np.interp(roll, omega, [flow.added_mass[ROLL, ROLL] for flow in flows]))
    return assemble(hull, flows, heading, roll, viscous_roll(hull, added))


def assemble(hull: Hull, flows: list[Flow], heading: Array, roll: float, damping: float) -> Response:
    """Return what ``flows`` make the hull do with ``damping`` added to that of roll."""
    directions = -heading
    moved = [motion(hull, flow, damping) for flow in flows]
    pairs = list(zip(flows, moved, strict=True))
    horizontal = np.ix_([0, 1, 5], [0, 1, 5])
    signs = TO_BODY[[0, 1, 5]]
    errors = [lost(flow, x, directions) - spent(flow, x, damping) for flow, x in pairs]
    return Response(
        np.array([flow.frequency for flow in flows]),
        heading,
        np.array(moved) * TO_BODY,
        np.array([drift(flow, x, directions, damping) for flow, x in pairs]) * signs,
        zero_frequency_added_mass(hull)[horizontal] * np.outer(signs, signs),
        roll,
        np.array(errors) / hull.form.beam,
    )
