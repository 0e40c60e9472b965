"""How far one direction is attainable."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.axes import HORIZONTAL
from marine_model.errors import InputError
from marine_model.guards import finite_vector
from thrust_allocator.attainable.axes_margin import AxesMargin
from thrust_allocator.attainable.force_set import force_set
from thrust_allocator.attainable.margin import reach


def scale_to_boundary(
    vessel: Vessel,
    azimuth: ArrayLike | None,
    direction: ArrayLike,
    *,
    enabled: Sequence[bool] | None = None,
    thrust_limit_scale: ArrayLike | None = None,
) -> float:
    """Return the largest s >= 0 such that ``s * direction`` is attainable.

    Exact: in closed form at given angles, to 1e-12 of the whole thrust with turning thrusters, NaN with these where
    :class:`AxesMargin` does not know it. 0 where nothing of the
    direction is attainable. Rate limits and forbidden sectors do not count.

    Parameters
    ----------
    vessel
        The vessel.
    azimuth
        Directions of all thrusters, shape (n,), rad; a tunnel keeps its own whatever stands here. Thrust of each is
        within its limits, so that the attainable set is a zonotope. None: azimuth thrusters turn freely, and each gives
        any force within a disc.
    direction
        Generalized force over the degrees of freedom of the vessel, shape (m,), N or N m in the body frame, of any
        length but zero.
    enabled
        n bools; False: the thruster is lost.
    thrust_limit_scale
        Fraction of both thrust limits that may be used, shape (n,), 0 to 1.

    Raises
    ------
    InputError
        If a shape is wrong, a number is not finite or out of range, or the direction is zero.
    """
    along = finite_vector("direction", direction, len(vessel.degrees_of_freedom))
    if not along.any():
        raise InputError(f"direction: expected a generalized force other than zero, found {along.tolist()}")
    if vessel.degrees_of_freedom == HORIZONTAL:
        return reach(force_set(vessel, azimuth, enabled=enabled, thrust_limit_scale=thrust_limit_scale), along)[0]
    n = len(vessel.thrusters)
    margin = AxesMargin(vessel, enabled=enabled, thrust_limit_scale=thrust_limit_scale)
    if azimuth is not None:
        return margin(finite_vector("azimuth", azimuth, n), along).fixed
    return margin(vessel.fixed_direction, along).turning
