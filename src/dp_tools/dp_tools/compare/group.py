"""Axes that share thrusters, with these along the fixed directions of the vessel file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dp_tools.compare.polytope import Polytope, octahedron, pseudo_inverse_set, zonotope
from marine_model import Vessel
from marine_model.axes import AXES, FORCE_UNITS, Axis
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import axis_limits, coupled_axes, pseudo_inverse, served_limits
from thrust_allocator.feasible.directions import along_direction

# Part of the largest element of its column below which an element is rounding; directions have 12 digits.
_NO_SHARE = 1e-9


@dataclass(frozen=True, eq=False)
class Group:
    """Some degrees of freedom and the thrusters that serve them.

    Attributes
    ----------
    axes, places
        Names, and where they stand among the degrees of freedom.
    thrusters
        Which thrusters of the vessel, in their order.
    columns
        B, generalized force per newton, shape (m, k).
    lower, upper
        Limits of thrust, shape (k,), N.
    strength
        f^max of the papers, who know one limit for both ways: the weaker, shape (k,), N.
    inverse
        B*, shape (k, m).
    printed, served
        Largest force of every axis, shape (m,): sum of all that thrusters give, by-products or not, [Garus-F], and
        what the pseudo-inverse gives without by-products.
    """

    axes: tuple[Axis, ...]
    places: tuple[int, ...]
    thrusters: tuple[int, ...]
    columns: FloatArray
    lower: FloatArray
    upper: FloatArray
    strength: FloatArray
    inverse: FloatArray
    printed: FloatArray
    served: FloatArray

    @property
    def units(self) -> tuple[str, ...]:
        """N or N m for every axis."""
        return tuple(FORCE_UNITS[AXES.index(axis)] for axis in self.axes)

    @property
    def name(self) -> str:
        """E.g. 'surge, sway, yaw'."""
        return ", ".join(self.axes)

    def attainable(self) -> Polytope:
        """Return all that the thrusters can give."""
        return zonotope(self.columns, self.lower, self.upper)

    def printed_octahedron(self) -> Polytope:
        """Return what (3.1) lets pass with the largest forces as printed."""
        return octahedron(self.printed)

    def served_octahedron(self) -> Polytope:
        """Return the same with the largest forces that are served without by-products."""
        return octahedron(self.served)

    def by_pseudo_inverse(self) -> Polytope:
        """Return what the pseudo-inverse gives within limits, reverse thrust as strong as it is."""
        return pseudo_inverse_set(self.inverse, self.lower, self.upper)


def groups_of(vessel: Vessel) -> tuple[Group, ...]:
    """Return the groups of coupled axes of ``vessel``.

    Raises
    ------
    InputError
        If a thruster pushes one way only: the methods know a limit for both ways.
    """
    for name, low, high in zip(vessel.thruster_names, vessel.thrust_min, vessel.thrust_max, strict=True):
        if not low < 0.0 < high:
            raise InputError(f"thruster '{name}': expected thrust both ways to compare, found {low:g} to {high:g} N")
    B = along_direction(vessel.columns, vessel.fixed_direction).T
    size = np.abs(B)
    shares = size > _NO_SHARE * size.max(axis=1)[:, None]
    found = []
    for places in coupled_axes(B):
        rows = np.array(places)
        used = np.flatnonzero(shares[rows].any(axis=0))
        columns = B[np.ix_(rows, used)]
        lower, upper = vessel.thrust_min[used], vessel.thrust_max[used]
        strength = np.minimum(upper, -lower)
        inverse = pseudo_inverse(columns, np.ones(len(used), dtype=np.bool_))
        found.append(
            Group(
                tuple(vessel.degrees_of_freedom[i] for i in places),
                places,
                tuple(used.tolist()),
                columns,
                lower,
                upper,
                strength,
                inverse,
                axis_limits(columns, strength),
                served_limits(columns, strength, inverse),
            )
        )
    return tuple(found)
