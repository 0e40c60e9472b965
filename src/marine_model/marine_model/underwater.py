"""A submerged body in six degrees of freedom, as a vessel file describes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray
from marine_model.matrix_checks import require_positive_definite, require_symmetric
from marine_model.schema import FieldError, Matrix3, NonNegative, Positive, Section, Vector3
from marine_model.units import Unit

NonNegativeVector6 = Annotated[
    tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative], Field(strict=False)
]

FinLift = Annotated[NonNegative, Unit("N s^2/m^2")]

# Vehicles are ballasted to the per cent; beyond this, buoyancy is taken for something else than newtons.
_BUOYANCY_OFF = 0.1


class Fins(Section):
    """Fixed fins: a force -k |u| times their velocity across, with k = rho A a / 2 of area A and slope of lift a.

    They hold a slender body against its Munk moment. Those that stand upright are alike above and below, those that lie
    alike on both sides.
    """

    x: Annotated[float, Unit("m")]  # ahead of the origin; negative at the stern
    radius: Annotated[NonNegative, Unit("m")]  # from the axis of the body to where the lift of a fin acts
    sway: FinLift  # k of all that stand upright
    heave: FinLift  # k of all that lie


class UnderwaterBody(Section):
    """Section ``underwater``: M nu_dot + C(nu) nu + D(nu) nu + g(eta) = tau (Fossen). The mass is ``hull.mass``."""

    buoyancy: Annotated[Positive, Unit("N")]  # rho g times the displaced volume
    centre_of_gravity: Annotated[Vector3, Unit("m")]  # body frame
    centre_of_buoyancy: Annotated[Vector3, Unit("m")]  # body frame
    inertia: Annotated[Matrix3, Unit("kg m^2")]  # about the origin of the body frame
    # Diagonals: surge, sway, heave, roll, pitch, yaw. Damping acts on the velocity through the water.
    added_mass: Annotated[NonNegativeVector6, Unit("kg, kg, kg, kg m^2, kg m^2, kg m^2")]
    linear_damping: Annotated[NonNegativeVector6, Unit("N s/m, N s/m, N s/m, N m s, N m s, N m s")]
    quadratic_damping: Annotated[NonNegativeVector6, Unit("N s^2/m^2, N s^2/m^2, N s^2/m^2, N m s^2, N m s^2, N m s^2")]
    fins: Fins | None = None

    @model_validator(mode="after")
    def _physical(self) -> Self:
        require_symmetric("inertia", self.inertia)
        require_positive_definite("inertia", self.inertia)
        damped = zip(self.linear_damping, self.quadratic_damping, strict=True)
        for axis, (linear, quadratic) in enumerate(damped):
            if linear == 0.0 and quadratic == 0.0:
                raise FieldError(("linear_damping", axis), "expected above 0 here or in quadratic_damping, found 0")
        return self

    def rigid_body_mass(self, mass: float) -> FloatArray:
        """Return M_RB about the origin, shape (6, 6), of a body of ``mass`` (kg).

        With r_g the centre of gravity, S(r) a = r x a: [[m I, -m S(r_g)], [m S(r_g), I_o]] (Fossen).
        """
        x, y, z = self.centre_of_gravity
        cross = mass * np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = mass * np.eye(3)
        matrix[:3, 3:] = -cross
        matrix[3:, :3] = cross
        matrix[3:, 3:] = self.inertia
        return matrix

    def total_mass(self, mass: float) -> FloatArray:
        """Return M_RB + M_A, shape (6, 6)."""
        return self.rigid_body_mass(mass) + np.diag(self.added_mass)

    def righting_moment(self, mass: float) -> float:
        """Return the moment that rights a body of ``mass`` (kg) per radian of roll or pitch, N m: W z_g - B z_b."""
        return mass * GRAVITY * self.centre_of_gravity[2] - self.buoyancy * self.centre_of_buoyancy[2]


def check_body(body: UnderwaterBody, mass: float, axes: Sequence[str]) -> None:
    """Check the section ``underwater`` against the rest of a vessel file.

    Parameters
    ----------
    body
        The section.
    mass
        ``hull.mass``, kg.
    axes
        The degrees of freedom that are controlled.

    Raises
    ------
    FieldError
        If no body of this mass has this inertia, buoyancy and weight are far apart, or nothing rights the body in
        roll or pitch that is not controlled either.
    """
    r = np.array(body.centre_of_gravity)
    central = np.array(body.inertia) - mass * (r @ r * np.eye(3) - np.outer(r, r))
    if np.linalg.eigvalsh(central)[0] <= 0.0:
        raise FieldError(
            ("underwater", "inertia"),
            "expected more than the mass has in its centre of gravity, about the origin of the body frame, "
            f"found {np.diag(body.inertia).tolist()} with {mass} kg at {r.tolist()} m",
        )
    weight = mass * GRAVITY
    if abs(body.buoyancy - weight) > _BUOYANCY_OFF * weight:
        raise FieldError(
            ("underwater", "buoyancy"),
            f"expected the weight of hull.mass, {weight:.6g} N, within {_BUOYANCY_OFF:.0%}, found {body.buoyancy} N",
        )
    passive = [axis for axis in ("roll", "pitch") if axis not in axes]
    righting = body.righting_moment(mass)
    if passive and righting <= 0.0:
        raise FieldError(
            ("underwater", "centre_of_buoyancy"),
            f"expected above the centre of gravity, because nothing else rights it in {' and '.join(passive)}, "
            f"found a moment of {righting:.6g} N m per radian",
        )
