"""A vessel whose hull is a box in waves, whatever its file says."""

from __future__ import annotations

from marine_model import Vessel
from vessel_sim.waves import HullForm

DRIFT_COEFFICIENT = (0.5, 0.87, 0.0)


def with_box_hull(vessel: Vessel) -> Vessel:
    """Return ``vessel`` with the box and fixed coefficients of its drift."""
    return Vessel.model_validate(vessel.model_dump() | {"wave_forces": {"drift_coefficient": DRIFT_COEFFICIENT}})


def box_of(vessel: Vessel) -> HullForm:
    """Return the box of ``vessel`` with the same coefficients."""
    return HullForm.of(vessel, DRIFT_COEFFICIENT)
