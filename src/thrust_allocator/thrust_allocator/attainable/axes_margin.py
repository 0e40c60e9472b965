"""The margin of a demand over any of the six degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_model import Vessel
from marine_model.axes import AXES, HORIZONTAL
from marine_model.guards import FloatArray
from thrust_allocator.attainable.force_set import flags, limit_fraction
from thrust_allocator.attainable.margin import Margin, margins
from thrust_allocator.attainable.zonotope import facets, zonotope_scale
from thrust_allocator.feasible.directions import along_direction
from thrust_allocator.feasible.octahedron import coupled_axes
from thrust_allocator.singularity import scaling_of

_Part = Callable[[FloatArray, FloatArray], tuple[float, float]]


class AxesMargin:
    """As :class:`margin.ThrustMargin`, for vessels that control other axes than surge, sway and yaw.

    Axes that share no thruster are looked at apart: the margin is the least of theirs. Exact for groups of thrusters
    that cannot turn, and for surge, sway and yaw with any. Of other groups with azimuth thrusters the margin once
    turned is not known, and NaN.

    Parameters
    ----------
    vessel, enabled, thrust_limit_scale, can_rotate
        As there.
    """

    def __init__(
        self,
        vessel: Vessel,
        *,
        enabled: Sequence[bool] | None = None,
        thrust_limit_scale: ArrayLike | None = None,
        can_rotate: Sequence[bool] | None = None,
    ) -> None:
        n = len(vessel.thrusters)
        fraction = limit_fraction(vessel, enabled, thrust_limit_scale)
        self._lower, self._upper = vessel.thrust_min * fraction, vessel.thrust_max * fraction
        self._turns = np.array(vessel.can_rotate) if can_rotate is None else flags("can_rotate", can_rotate, n)
        self._vessel, self._length = vessel, scaling_of(vessel).typical_arm
        # What can turn may give either component, whether it does now or not.
        along = along_direction(vessel.columns, vessel.fixed_direction)
        either = np.abs(vessel.columns).sum(axis=2)
        shares = np.where(np.array(vessel.can_rotate)[:, None], either, np.abs(along))
        self._parts: list[tuple[list[int], _Part]] = []
        for group in coupled_axes(shares.T):
            axes = tuple(vessel.degrees_of_freedom[i] for i in group)
            own = np.flatnonzero(shares[:, group].any(axis=1))
            part = self._horizontal(own) if axes == HORIZONTAL else self._general(own, list(group))
            self._parts.append((list(group), part))

    def __call__(self, azimuth: FloatArray, tau: FloatArray) -> Margin:
        """Return the margin of a demand.

        Parameters
        ----------
        azimuth
            Present directions, shape (n,), rad; those of thrusters that cannot turn are not read.
        tau
            Demanded generalized force over the degrees of freedom, shape (m,), N or N m.
        """
        fixed = turning = math.inf
        for group, part in self._parts:
            demand = tau[group]
            if demand.any():
                at, once = part(azimuth, demand)
                fixed = min(fixed, at)
                turning = math.nan if math.isnan(once) or math.isnan(turning) else min(turning, once)
        return Margin(fixed, turning)

    def _horizontal(self, own: NDArray[np.intp]) -> _Part:
        """Return the margin in surge, sway and yaw of the thrusters ``own``."""
        vessel, length = self._vessel, self._length
        along = along_direction(vessel.columns6, vessel.fixed_direction)[own]
        can_rotate = np.array(vessel.can_rotate)[own]
        # Of one that is tilted the horizontal part counts.
        part = np.where(can_rotate, 1.0, np.hypot(along[:, 0], along[:, 1]))
        thrusters = np.column_stack(
            [
                vessel.lever_x[own] / length,
                vessel.lever_y[own] / length,
                self._lower[own] * part,
                self._upper[own] * part,
                self._turns[own],
                np.where(can_rotate, np.nan, np.arctan2(along[:, 1], along[:, 0])),
            ]
        ).astype(np.float64, order="C")
        return lambda azimuth, tau: margins(
            thrusters, length, np.ascontiguousarray(azimuth[own]), np.ascontiguousarray(tau)
        )

    def _general(self, own: NDArray[np.intp], group: list[int]) -> _Part:
        """Return the margin in the axes ``group`` of the thrusters ``own``."""
        vessel = self._vessel
        balance = np.array([1.0 if AXES.index(vessel.degrees_of_freedom[i]) < 3 else 1.0 / self._length for i in group])
        columns = vessel.columns[np.ix_(own, np.array(group))] * balance[:, None]
        lower, upper = self._lower[own], self._upper[own]
        if not np.array(vessel.can_rotate)[own].any():
            known = facets(along_direction(columns, vessel.fixed_direction[own]), lower, upper)

            def fixed(azimuth: FloatArray, tau: FloatArray) -> tuple[float, float]:
                scale = zonotope_scale(known, tau * balance)
                return scale, scale

            return fixed
        held = ~np.array(vessel.can_rotate)[own]
        any_turns = bool(self._turns[own].any())

        def at_angles(azimuth: FloatArray, tau: FloatArray) -> tuple[float, float]:
            angles = np.where(held, vessel.fixed_direction[own], azimuth[own])
            scale = zonotope_scale(facets(along_direction(columns, angles), lower, upper), tau * balance)
            return scale, math.nan if any_turns else scale

        return at_angles
