"""How the results depend on the size of the panels: what ``--convergence`` prints."""

from __future__ import annotations

import time

import capytaine as cpt
import numpy as np

from hydrodynamics.body import HEAVE, PITCH, ROLL, Hull
from hydrodynamics.hull_form import Array
from hydrodynamics.motions import viscous_roll
from hydrodynamics.response import assemble, natural_roll_frequency
from hydrodynamics.solve import solve
from marine_model.vessel import Vessel

PANELS = (0.05, 0.035, 0.025, 0.018)
FREQUENCIES = (2.5, 3.5, 5.0)
HEADINGS: Array = np.radians([90.0, 135.0, 180.0])
BEAM, BOW, HEAD = range(3)

COLUMNS = (
    "panel / L",
    "panels",
    "s a frequency",
    "slow added mass: surge",
    "sway",
    "yaw (1e-3 of rho L^3, rho L^5)",
    "roll frequency",
    *(
        f"{what} at {w}"
        for w in FREQUENCIES
        for what in ("head heave", "head pitch", "head surge drift", "beam drift", "bow yaw")
    ),
)


def table(vessel: Vessel) -> str:
    """Return a table in Markdown, a row for every quantity and a column for every panel size."""
    columns = [_column(vessel, panel) for panel in PANELS]
    rows = ["| " + " | ".join([name, *cells]) + " |" for name, *cells in zip(COLUMNS, *columns, strict=True)]
    return "\n".join([rows[0], "| --- " * (len(PANELS) + 1) + "|", *rows[1:]])


def _column(vessel: Vessel, panel: float) -> list[str]:
    particulars = vessel.hull
    volume = particulars.mass / vessel.density
    hull = Hull.of(particulars.length, particulars.beam, particulars.draught, volume, panel)
    solver = cpt.BEMSolver()
    roll = natural_roll_frequency(solver, hull)
    start = time.monotonic()
    flows = [solve(solver, hull, w, -HEADINGS) for w in FREQUENCIES]
    spent = (time.monotonic() - start) / len(flows)
    damping = viscous_roll(hull, float(flows[0].added_mass[ROLL, ROLL]))
    response = assemble(hull, flows, HEADINGS, roll, damping)
    cells = [f"{panel:g}", f"{hull.body.mesh_including_lid.nb_faces}", f"{spent:.1f}"]
    cells += [f"{1e3 * response.slow_added_mass[i, i]:.4f}" for i in range(3)] + [f"{roll:.4f}"]
    for motion, drift in zip(response.motion, response.drift, strict=True):
        cells += [f"{abs(motion[HEAD, HEAVE]):.4f}", f"{abs(motion[HEAD, PITCH]):.4f}", f"{drift[HEAD, 0]:.4f}"]
        cells += [f"{drift[BEAM, 1]:.4f}", f"{drift[BOW, 2]:.4f}"]
    return cells
