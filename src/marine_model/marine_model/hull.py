"""Hull of a vessel: particulars, manoeuvring coefficients and response to waves."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.matrix_checks import require_positive_definite, require_symmetric
from marine_model.schema import FieldError, Matrix3, NonNegativeVector3, Positive, Section, Vector3
from marine_model.units import Unit

# Surge, sway, yaw.
MassMatrix = Annotated[Matrix3, Unit("kg, kg, kg m; kg, kg, kg m; kg m, kg m, kg m^2")]
DampingMatrix = Annotated[Matrix3, Unit("N s/m, N s/m, N s; N s/m, N s/m, N s; N s, N s, N m s")]


class Particulars(Section):
    """Main dimensions, at the scale of the file."""

    length: Annotated[Positive, Unit("m")]  # between perpendiculars
    beam: Annotated[Positive, Unit("m")]
    draught: Annotated[Positive, Unit("m")]
    mass: Annotated[Positive, Unit("kg")]
    # Positive with the bow down; beyond what a ship floats at it is taken for degrees.
    trim: Annotated[float, Field(ge=-0.3, le=0.3), Unit("rad")] = 0.0


class Manoeuvring(Section):
    """Low-frequency model: (M_RB + M_A) nu_dot + C(nu) nu + D nu + D_q |nu| nu = tau (Fossen)."""

    rigid_body_mass: MassMatrix
    added_mass: MassMatrix
    linear_damping: DampingMatrix
    # Acts on relative velocity.
    quadratic_damping: Annotated[NonNegativeVector3, Unit("N s^2/m^2, N s^2/m^2, N m s^2")]

    @model_validator(mode="after")
    def _physical(self) -> Self:
        total = np.array(self.rigid_body_mass) + np.array(self.added_mass)
        require_symmetric("rigid_body_mass + added_mass", total)
        require_positive_definite("rigid_body_mass", self.rigid_body_mass)
        require_positive_definite("rigid_body_mass + added_mass", total)
        require_positive_definite("linear_damping", self.linear_damping)
        return self


class WaveForces(Section):
    """What waves do to the hull: the box of its main dimensions, or a data file. One of the two is given.

    Box: the mean second-order force in regular waves of amplitude a from relative direction b is
    X = c0 (rho g a^2 B / 2) cos b,  Y = c1 (rho g a^2 L / 2) sin b |sin b|,  N = c2 (rho g a^2 L B / 2) sin 2b,
    with b = 0 for waves that travel ahead along the body x-axis.

    Data file: motion and drift of ``marine_model.wave_response``, the drift times ``drift_factor``.
    """

    drift_coefficient: Annotated[Vector3, Unit("1")] | None = None
    response: Annotated[str, Field(min_length=1)] | None = None
    drift_factor: Annotated[Positive, Unit("1")] = 1.0

    @model_validator(mode="after")
    def _box_or_file(self) -> Self:
        if (self.drift_coefficient is None) == (self.response is None):
            found = "neither" if self.response is None else "both"
            raise ValueError(f"expected either drift_coefficient or response, found {found}")
        if self.response is None and self.drift_factor != 1.0:
            raise FieldError(("drift_factor",), "expected none beside drift_coefficient, found one")
        return self
