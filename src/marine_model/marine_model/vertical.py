"""Observer and controller gains of heave, roll and pitch: every axis for itself."""

from __future__ import annotations

from typing import Annotated

from marine_model.schema import NonNegativeVector3, Positive, PositiveVector3, Section
from marine_model.units import Unit


class VerticalObserverGains(Section):
    """Model of each of heave, roll and pitch, m v' = -d v - k x + b + tau, and poles of its observer."""

    mass: Annotated[PositiveVector3, Unit("kg, kg m^2, kg m^2")]  # with added mass
    damping: Annotated[PositiveVector3, Unit("N s/m, N m s, N m s")]
    stiffness: Annotated[NonNegativeVector3, Unit("N/m, N m/rad, N m/rad")]  # restoring
    bandwidth: Annotated[PositiveVector3, Unit("rad/s")]  # the error has three poles there


class VerticalReferenceGains(Section):
    """Second-order reference generator of each axis."""

    frequency: Annotated[Positive, Unit("rad/s")]
    damping: Annotated[Positive, Unit("1")]
    velocity_max: Annotated[PositiveVector3, Unit("m/s, rad/s, rad/s")]


class VerticalControllerGains(Section):
    """PID of each of heave, roll and pitch."""

    proportional: Annotated[NonNegativeVector3, Unit("N/m, N m/rad, N m/rad")]
    integral: Annotated[NonNegativeVector3, Unit("N/(m s), N m/(rad s), N m/(rad s)")]
    derivative: Annotated[NonNegativeVector3, Unit("N s/m, N m s/rad, N m s/rad")]
    reference: VerticalReferenceGains


class VerticalGains(Section):
    """Section ``vertical`` of a submerged vehicle's file."""

    observer: VerticalObserverGains
    controller: VerticalControllerGains
