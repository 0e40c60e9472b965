"""A submerged body in six degrees of freedom, as a vessel file describes it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from marine_model.schema import Matrix3, NonNegative, Positive, Section, Vector3
from marine_model.units import Unit

NonNegativeVector6 = Annotated[
    tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative], Field(strict=False)
]


class UnderwaterBody(Section):
    """Section ``underwater``: M nu_dot + C(nu) nu + D(nu) nu + g(eta) = tau (Fossen). The mass is ``hull.mass``."""

    buoyancy: Annotated[Positive, Unit("N")]  # rho g times the displaced volume
    centre_of_gravity: Annotated[Vector3, Unit("m")]  # body frame
    centre_of_buoyancy: Annotated[Vector3, Unit("m")]  # body frame
    inertia: Annotated[Matrix3, Unit("kg m^2")]  # about the origin of the body frame
    # Diagonals: surge, sway, heave, roll, pitch, yaw.
    added_mass: Annotated[NonNegativeVector6, Unit("kg, kg, kg, kg m^2, kg m^2, kg m^2")]
    linear_damping: Annotated[NonNegativeVector6, Unit("N s/m, N s/m, N s/m, N m s, N m s, N m s")]
    quadratic_damping: Annotated[NonNegativeVector6, Unit("N s^2/m^2, N s^2/m^2, N s^2/m^2, N m s^2, N m s^2, N m s^2")]
