"""The hull of a vessel in waves."""

from __future__ import annotations

from marine_model.vessel import Vessel
from vessel_sim.waves.computed_hull import ComputedHull
from vessel_sim.waves.hull_form import HullForm
from vessel_sim.waves.hull_in_waves import HullInWaves


def hull_in_waves(vessel: Vessel) -> HullInWaves:
    """Return the hull with the computed response that the vessel file names, and as a box where it names none."""
    response = vessel.wave_response
    if response is None:
        return HullForm.of(vessel)
    return ComputedHull(response, vessel.hull.length, vessel.density, vessel.on_surface()[1].drift_factor)
