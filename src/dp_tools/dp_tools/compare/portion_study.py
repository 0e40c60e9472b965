"""Marching thrusters in a cross: what portions of [Kostenko] (6) reach beside what the thrusters can give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dp_tools.compare.group import Group
from dp_tools.compare.polytope import Polytope, inside
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import Cross, Portions, portion
from thrust_allocator.methods.cross import AXES, cross_of

PLANES = (("surge", "yaw"), ("surge", "pitch"))
# P_x of the table; the one in the middle is drawn by itself.
SHARES = (0.2, 0.35, 0.5, 0.65, 0.8)
_MIDDLE = 0.5


@dataclass(frozen=True)
class PortionRow:
    """One set of portions, P_phi = P_psi = 1 - P_x.

    Attributes
    ----------
    surge_portion
        P_x.
    limits
        Largest demand of every axis alone, N or N m, over ``AXES``.
    area_ratios
        Rectangle of the portions over the attainable set, in the planes.
    met
        Share of the random demands that are met whole.
    """

    surge_portion: float
    limits: tuple[float, float, float, float]
    area_ratios: tuple[float, float]
    met: float


@dataclass(frozen=True, eq=False)
class PortionStudy:
    """All of a cross.

    Attributes
    ----------
    thrust_max
        T_max at rest, N.
    sections
        What is attainable in the planes, other axes zero.
    limits
        Largest attainable of every axis alone.
    rows
        Portions.
    count, attainable
        Random demands, uniform in the box of these limits: how many, and the share that is attainable.
    """

    thrust_max: float
    sections: tuple[Polytope, Polytope]
    limits: tuple[float, float, float, float]
    rows: tuple[PortionRow, ...]
    count: int
    attainable: float

    @property
    def middle(self) -> PortionRow:
        """The row with equal portions."""
        return next(row for row in self.rows if row.surge_portion == _MIDDLE)


def cross_with_limit(vessel: Vessel) -> tuple[Cross, float] | None:
    """Return geometry and T_max (N) at rest of a vessel with the thrusters of (5); None if it has others."""
    try:
        found = cross_of(vessel)
    except InputError:
        return None
    *marching, bow = found.order
    low, high = sorted((found.bow_sign * float(vessel.thrust_min[bow]), found.bow_sign * float(vessel.thrust_max[bow])))
    strength = np.minimum(vessel.thrust_max, -vessel.thrust_min)[marching]
    return Cross(found.angle, found.stern_arm, found.bow_arm, low, high), float(strength.min())


def study_portions(
    cross: Cross, thrust_max: float, group: Group, exact: Polytope, demands: int, generator: np.random.Generator
) -> PortionStudy:
    """Return the study of a cross at rest.

    Parameters
    ----------
    cross, thrust_max
        As from :func:`cross_with_limit`.
    group, exact
        The four axes and their attainable set.
    demands, generator
        How many random demands, and where they come from.
    """
    first, second = (exact.section([group.axes.index(axis) for axis in plane]) for plane in PLANES)
    limits = 1.0 / exact.load(np.eye(4))
    tau = generator.uniform(-1.0, 1.0, (demands, 4)) * limits
    rows = []
    for share in SHARES:
        portions = Portions(share, 1.0 - share, 1.0 - share)
        own = 1.0 / _load(np.eye(4), cross, portions, thrust_max)
        areas = [4.0 * own[AXES.index(one)] * own[AXES.index(other)] for one, other in PLANES]
        rows.append(
            PortionRow(
                share,
                _four(own),
                (float(areas[0]) / first.volume, float(areas[1]) / second.volume),
                float(inside(_load(tau, cross, portions, thrust_max)).mean()),
            )
        )
    return PortionStudy(
        thrust_max, (first, second), _four(limits), tuple(rows), demands, float(inside(exact.load(tau)).mean())
    )


def _load(tau: FloatArray, cross: Cross, portions: Portions, thrust_max: float) -> FloatArray:
    """Return the load of demands (k, 4) over ``AXES``: the portions are rectangles, it grows with the demand."""
    load: FloatArray = portion(tau[:, 0], tau[:, 1], tau[:, 2], tau[:, 3], cross, portions, thrust_max).load
    return load


def _four(values: FloatArray) -> tuple[float, float, float, float]:
    one, two, three, four = values.tolist()
    return one, two, three, four
