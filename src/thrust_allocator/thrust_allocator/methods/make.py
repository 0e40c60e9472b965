"""The method that settings name, and whether it fits the vessel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from marine_model import Vessel
from marine_model.errors import InputError
from thrust_allocator.feasible.garus_azimuth import largest_moment
from thrust_allocator.feasible.portioned import Portions
from thrust_allocator.methods.azimuth import GarusAzimuthMethod, azimuth_square
from thrust_allocator.methods.cross import PortionedMethod, cross_of
from thrust_allocator.methods.method import Method
from thrust_allocator.methods.pseudo import PseudoInverseMethod
from thrust_allocator.methods.speed_limit import speed_limit_of

if TYPE_CHECKING:
    from thrust_allocator.settings import AllocatorSettings


def make_method(vessel: Vessel, settings: AllocatorSettings) -> Method | None:
    """Return the method of ``settings``; None for the quadratic program.

    Raises
    ------
    InputError
        If it does not fit the vessel, or its own settings do not.
    """
    axes = vessel.degrees_of_freedom
    if settings.method == "qp":
        return None
    if settings.method == "garus_azimuth":
        return GarusAzimuthMethod(vessel, settings.garus_azimuth)
    if settings.method == "portioned":
        shares = settings.portions
        portions = Portions(shares.surge, shares.yaw, shares.pitch)
        return PortionedMethod(vessel, portions, shares.speed_limited)
    weights = np.array(settings.priority.weights or (1.0,) * len(axes))
    axis = axes.index(settings.priority.axis) if settings.feasible == "priority" else 0
    return PseudoInverseMethod(vessel, settings.feasible, axis, weights)


def default_moment(vessel: Vessel) -> float:
    """Return a quarter of the yaw moment that four azimuth propellers give at any angle, N m: [Garus-A] has 50 of 200.

    0 for a vessel that has no such four.
    """
    try:
        return 0.25 * largest_moment(azimuth_square(vessel), 0.0)
    except InputError:
        return 0.0


def knows_speed(vessel: Vessel) -> bool:
    """Return whether portions can be those of the thrust at the present speed."""
    try:
        cross = cross_of(vessel)
    except InputError:
        return False
    return speed_limit_of(vessel, cross.order[:4]) is not None


def check_method(settings: AllocatorSettings, vessel: Vessel) -> None:
    """Check that a method fits the vessel, and that nothing is asked beside it that only the program does.

    Raises
    ------
    InputError
        Where it does not.
    """
    axes = vessel.degrees_of_freedom
    found = len(settings.priority.weights)
    if found not in (0, len(axes)):
        raise InputError(
            f"priority.weights: expected {len(axes)} elements, one for each of {', '.join(axes)}, found {found}"
        )
    shares = settings.portions
    Portions(shares.surge, shares.yaw, shares.pitch)
    method = settings.method
    if method == "qp":
        return
    inert = {
        "sectors.enabled": settings.sectors.enabled,
        "power.limit": settings.power.limit != "none",
        "singularity.method": settings.singularity.method != "none",
        "antispin.enabled": settings.antispin.enabled,
    }
    for name, asked in inert.items():
        if asked:
            raise InputError(
                f"{name}: expected nothing with method = {method}, which only qp knows, found it asked for"
            )
    if method == "pseudo_inverse" and settings.feasible != "none":
        if settings.feasible == "priority" and settings.priority.axis not in axes:
            raise InputError(f"priority.axis: expected one of {', '.join(axes)}, found '{settings.priority.axis}'")
        one_way = [t.name for t in vessel.thrusters if t.thrust.min >= 0.0 or t.thrust.max <= 0.0]
        if one_way:
            raise InputError(
                f"feasible: expected none where a thruster does not reverse, found '{settings.feasible}' with "
                f"{', '.join(one_way)}"
            )
    make_method(vessel, settings)
