"""What a data file says of itself."""

from __future__ import annotations

import capytaine as cpt
import numpy as np

from hydrodynamics import body
from hydrodynamics.body import HEAVE, Hull
from hydrodynamics.response import Response
from marine_model.vessel import Vessel


def comments(vessel: Vessel, hull: Hull, response: Response, panel: float) -> list[str]:
    """Return the lines above the table."""
    form, particulars = hull.form, vessel.hull
    metres, kilograms = particulars.length, vessel.density * particulars.length**3
    slow, height = response.slow_added_mass, hull.centre_of_gravity
    arm, turn = kilograms * metres, kilograms * metres**2
    return [
        f"Response of the hull of {vessel.name} to regular deep-water waves at zero speed. docs/hydrodynamics.md",
        f"Written by scripts/hydrodynamics with capytaine {cpt.__version__}; not to be edited by hand.",
        f"hull: L {particulars.length:g} m, B {particulars.beam:g} m, T {particulars.draught:g} m, "
        f"{particulars.mass:g} kg in water of {vessel.density:g} kg/m^3",
        f"form: C_W {form.waterplane:.4f}, C_M {form.midship:.4f}, d {form.fining:.4f} (parametric, fore-and-aft "
        "symmetric, even keel)",
        f"panels: {hull.body.mesh.nb_faces} on the hull, {hull.body.lid_mesh.nb_faces} on its lid, side {panel:g} L",
        f"GM {body.METACENTRIC_HEIGHT:g} B; radii of gyration {body.RADIUS_ROLL:g} B (roll), {body.RADIUS_PITCH:g} L "
        f"(pitch), {body.RADIUS_YAW:g} L (yaw); viscous roll damping {body.VISCOUS_ROLL:g} of critical",
        f"centre of gravity {metres * abs(height):.4g} m {'above' if height > 0.0 else 'below'} the waterline",
        f"roll resonates at omega sqrt(L / g) = {response.roll_frequency:.3f}, heave is largest at "
        f"{_heave(response):.2f}",
        "added mass in slow motion: surge "
        f"{kilograms * slow[0, 0]:.4g} kg, sway {kilograms * slow[1, 1]:.4g} kg, yaw {turn * slow[2, 2]:.4g} kg m^2, "
        f"sway-yaw {arm * slow[1, 2]:.2g} kg m",
        "energy: the two measures of what a train loses differ by at most "
        f"{np.abs(response.energy_error).max():.1%} of what is on the beam of the ship",
        "frequency: omega sqrt(L / g). heading: rad, 0 for waves that travel ahead, pi for head seas.",
        "motion X, x(t) = a Re[X exp(i theta)]: surge, sway, heave (down) over a; roll, pitch (bow up), yaw over "
        "a / L.",
        "drift: surge, sway over rho g L a^2, yaw over rho g L^2 a^2.",
    ]


def _heave(response: Response) -> float:
    """Return the frequency at which heave is largest in beam seas."""
    beam = int(np.argmin(np.abs(response.heading - 0.5 * np.pi)))
    return float(response.frequency[np.argmax(np.abs(response.motion[:, beam, HEAVE]))])
